"""The exit codes of `fea`, which its help lists; 0 is done."""

USAGE = 2  # or a study that is refused
GEOMETRY = 3  # no solid or no mesh
SINGULAR = 4  # or under-constrained
CHECK_FAILED = 5  # not to be trusted
UNSAFE = 6  # below --min-safety
MACHINE = 7  # cannot: a library, memory, the disk, a picture
INTERRUPTED = 130
