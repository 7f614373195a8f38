"""The searches where costs change with time: kernels of their own, and the loops around them.

Tours are the rings of `formulations.routing.search`, whose legs carry what they cost at half time: that is what ruins
and moves of long segments go by. What a tour takes by the clock is booked beside them (``bookings.py``).
"""
