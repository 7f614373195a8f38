"""Re-planning in flight: what was measured decides what is flown next (conditional information, open routes, rules)."""
