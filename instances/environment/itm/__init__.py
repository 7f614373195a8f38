"""The Irregular Terrain Model (Longley-Rice), point to point: what Radio Mobile computes for the paper.

Source: G. A. Hufford, "The ITS Irregular Terrain Model, version 1.2.2: The Algorithm" (NTIA/ITS, 1995), cited below as
[Alg]; Tech Note 101 (Rice et al. 1967) as [TN101]; Longley & Reasoner, ERL 79-ITS 67 (1970), as [ERL79]. Constants
as in NTIA's reference implementation (github.com/NTIA/itm). Lengths in metres, frequencies in MHz, losses in dB.

profile.py      what a terrain profile says: horizons, effective heights, irregularity Δh
attenuation.py  reference attenuation: line of sight, diffraction, troposcatter
variability.py  quantiles over time, locations and situations
loss.py         basic transmission loss of a path and of a map
"""
