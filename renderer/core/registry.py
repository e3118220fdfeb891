"""Registries: kinds found by the name that scene files have for them."""


class Registry(dict):
    """{name: kind}; a name is taken once."""

    def add(self, name, kind):
        """Enter a kind under a name that is still free."""
        assert name not in self, name
        self[name] = kind

    def register(self, kind):
        """Enter a kind that knows its own name."""
        self.add(kind.name, kind)

    def under(self, name):
        """Return a class decorator that enters a class under a name."""

        def enter(kind):
            self.add(name, kind)
            return kind

        return enter
