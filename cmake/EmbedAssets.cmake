# cmake -DASSETS="name=file;name=file" -DOUTPUT=assets.cpp -P EmbedAssets.cmake
# Raw string literals: a compiler takes a megabyte of them at once, where an array of as many numbers takes seconds.
set(content "// Written by CMake; do not edit.\n#include \"simgap/report/html/assets.h\"\nnamespace simgap::assets {\n")
foreach(asset ${ASSETS})
  string(FIND ${asset} "=" split)
  string(SUBSTRING ${asset} 0 ${split} name)
  math(EXPR split "${split} + 1")
  string(SUBSTRING ${asset} ${split} -1 file)
  file(READ ${file} text)
  string(FIND "${text}" ")asset\"" delimiter)
  if(NOT delimiter EQUAL -1)
    message(FATAL_ERROR "${file} holds the delimiter )asset\"")
  endif()
  string(APPEND content "static constexpr char k_${name}[] = R\"asset(${text})asset\";\n"
    "std::string_view ${name}() { return {k_${name}, sizeof(k_${name}) - 1}; }\n")
endforeach()
file(WRITE ${OUTPUT} "${content}}  // namespace simgap::assets\n")
