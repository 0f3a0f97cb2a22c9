#pragma once

#include <sys/types.h>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace trunnion {

/// A file that appears whole or not at all: written beside its place, then moved there by commit(). Without commit()
/// nothing is left, also when the process is killed (where the file system has files without names; elsewhere, when it
/// is interrupted by a signal that it can catch).
class OutputFile {
 public:
  /// Throws UsageError if `path` is one of `inputs`, also by another name or link; InputError if the place cannot be
  /// written. "-" is standard output; it, a device and a pipe get their text on commit() alone.
  OutputFile(std::string path, const std::vector<std::string>& inputs);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Throws InputError when the device is full or fails.
  void append(std::string_view text);
  /// Where everything appended so far stands until commit(), to be read again.
  std::string written();
  /// Makes the file appear, replacing what stood there.
  void commit();

 private:
  friend class OutputFolder;
  void flush();
  void take_name();
  void settle();                  ///< everything is on the device
  void stand_beside();            ///< under a name beside its place; nothing can be appended any more
  void move();                    ///< from there to its place
  std::string path_, temporary_;  ///< temporary_: empty while the file has no name
  std::string buffer_;
  int file_ = -1;
  bool replaces_ = false;  ///< a regular file, new or old; not a device, a pipe or standard output
  mode_t mode_ = 0;        ///< of the file that is replaced; 0 for a new one
};

/// OutputFile in one go.
void write_whole(const std::string& path, std::string_view text, const std::vector<std::string>& inputs);

/// Files of one folder that appear together: each is written beside its place first, then all are moved. Folders that
/// are missing are made; names may hold one level of sub-folders ("kinematics/map.h").
class OutputFolder {
 public:
  OutputFolder(std::string folder, std::vector<std::string> inputs);
  void add(std::string name, std::string text);
  /// Writes everything; on failure nothing new is left.
  void commit();

 private:
  std::string folder_;
  std::vector<std::string> inputs_;
  std::vector<std::pair<std::string, std::string>> files_;
};

}  // namespace trunnion
