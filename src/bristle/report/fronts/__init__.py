"""First pages, one for each kind of report: the verdict, its reasons, the answers to five questions, and a figure."""
