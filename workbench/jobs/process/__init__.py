"""The processes of one run: started, watched, heard and ended; nothing of what they say is believed here."""
