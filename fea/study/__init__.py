"""The input of a run: studies, their tables and the flags that override them."""
