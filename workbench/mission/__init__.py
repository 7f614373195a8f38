"""The paper's whole chain, stage by stage: environment → place → costs → routes → flight → map → compare → report.

Every stage reads the products of those before it from their folders and writes its own folder, aside and renamed.
"""
