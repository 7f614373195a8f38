"""Which tasks to fly when not everything fits: team orienteering, and information within endurance."""
