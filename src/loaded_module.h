#pragma once

#include <dlfcn.h>

#include <filesystem>
#include <string>

#include "error.h"

namespace trunnion {

/// Where a module of the program lies (`name`.so): beside the program, or in the library folder `libdir` (relative to
/// the prefix) of its installation; empty if in neither.
inline std::string module_path(const std::string& name, const std::string& libdir) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path here = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  for (const fs::path& candidate : {here / (name + ".so"), here / ".." / libdir / "trunnion" / (name + ".so")})
    if (fs::is_regular_file(candidate, ignored)) return candidate.lexically_normal().string();
  return "";
}

/// A function of a module, which stays loaded. `what` names the module's purpose in messages. Throws ModelError where
/// it cannot be loaded or has no such function.
inline void* module_function(const std::string& path, const char* name, const std::string& what) {
  void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) throw ModelError(what + " cannot be loaded: " + std::string(dlerror()));
  void* found = dlsym(library, name);
  if (found == nullptr) throw ModelError(path + ": no " + name + " in it; another version's module");
  return found;
}

}  // namespace trunnion
