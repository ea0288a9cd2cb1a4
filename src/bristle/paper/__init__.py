"""The source paper on the bench: its rig, its controller and its experiments, as files that anyone can change."""
