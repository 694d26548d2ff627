"""What is assumed where a study says nothing, in words."""


class Assumed(list[str]):
    """A list of assumptions."""

    def or_else(self, given: float | None, default: float, text: str) -> float:
        """Return what is given, or the default, which is noted; the text has a place for it."""
        if given is None:
            self.append(text.format(default))
            return default
        return given
