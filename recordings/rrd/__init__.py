"""The native form: a rerun file that the tools compute from and that a person reviews."""
