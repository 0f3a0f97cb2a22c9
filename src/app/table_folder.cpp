#include "app/table_folder.h"

#include <algorithm>
#include <filesystem>

#include "error.h"
#include "io/text_file.h"

namespace trunnion {

std::vector<TableFile> files_in(const std::string& folder) {
  namespace fs = std::filesystem;
  if (!fs::is_directory(folder)) throw InputError(folder, "a folder written by trunnion tables is wanted");
  std::vector<TableFile> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file())
      files.push_back({fs::relative(entry.path(), folder).generic_string(), read_text(entry.path().string())});
  std::ranges::sort(files, {}, &TableFile::name);
  return files;
}

}  // namespace trunnion
