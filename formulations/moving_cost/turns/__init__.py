"""Turns that count: moving costs between headings, for UAVs whose turning radius is not small beside the legs.

A state is a heading at a node; a leg leads from heading to heading and costs its Dubins length over the speed
(`travel`). `headings` says which headings a node has, `interval` how short a leg between sectors of headings is, `wind`
how long it takes in a steady wind, `refinement` with which headings given routes are flown, and `spacing` whether turns
matter at all.
"""
