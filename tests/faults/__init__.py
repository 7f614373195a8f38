"""The fault suite: hostile plug-ins and kills. Whatever they do is one stored run each, and nothing runs afterwards."""
