"""The report: one page without any outside reference, made from what lies in the results folder."""
