"""The machinery and the face: study, runner, store, mission, command line."""
