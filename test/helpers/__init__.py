"""Code shared by the tests; cmake/tests.cmake makes it importable in the devel space."""
