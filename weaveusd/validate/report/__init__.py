"""The report as files: one page for people, JSON and JUnit XML for machines."""
