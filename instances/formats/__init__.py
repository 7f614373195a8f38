"""One file per file format; `instances.files` chooses by the ending."""
