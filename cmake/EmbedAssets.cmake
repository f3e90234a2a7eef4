# cmake -DASSETS="name=file;name=file" -DOUTPUT=assets.cpp -P EmbedAssets.cmake
set(content "// Written by CMake; do not edit.\n#include \"simgap/report/assets.h\"\nnamespace simgap::assets {\n")
foreach(asset ${ASSETS})
  string(FIND ${asset} "=" split)
  string(SUBSTRING ${asset} 0 ${split} name)
  math(EXPR split "${split} + 1")
  string(SUBSTRING ${asset} ${split} -1 file)
  file(READ ${file} bytes HEX)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
  string(APPEND content "static constexpr unsigned char k_${name}[] = {${bytes}0};\n"
    "std::string_view ${name}() { return {reinterpret_cast<const char*>(k_${name}), sizeof(k_${name}) - 1}; }\n")
endforeach()
file(WRITE ${OUTPUT} "${content}}  // namespace simgap::assets\n")
