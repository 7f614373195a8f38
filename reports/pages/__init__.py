"""Pages: one builder on one base template; each page is a list of sections made of words, tables and figures."""
