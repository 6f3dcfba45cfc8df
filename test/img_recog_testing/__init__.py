"""What the tests share; CMakeLists.txt makes it importable in the devel space."""
