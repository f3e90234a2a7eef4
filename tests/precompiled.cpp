// Nothing: the headers that the test programs share are compiled with it (tests/CMakeLists.txt).
