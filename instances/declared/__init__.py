"""Files as typed declarations: each key once, with its type, bounds, unit, default, meaning and an example.

From a declaration a file is read (`reading`), what it takes is said in words (`words`), its JSON Schema made (`schema`)
and its tables for people (`tables`). Declarations of scenarios and instances are here, those of studies and missions in
`workbench`, that of a run in `reports.record`.
"""
