"""The tests: a package, since some library on the path brings one of the same name."""
