"""What a run is asked: studies, their tables and the flags that override them."""
