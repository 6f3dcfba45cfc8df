"""Code shared by the tests; CMakeLists.txt makes it importable in the devel space."""
