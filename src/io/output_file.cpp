#include "io/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

#include "error.h"

namespace trunnion {
namespace {

InputError cannot_write(const std::string& path, const std::string& why) {
  return InputError(path, "cannot be written: " + why);
}

// Temporary files that a signal must take away. A signal handler may only touch what needs no lock: fixed slots of
// names.
constexpr std::size_t kSlots = 64, kLongest = 4096;
struct Slot {
  std::atomic<bool> taken{false};
  std::atomic<bool> live{false};
  std::array<char, kLongest> name{};
};
std::array<Slot, kSlots> g_slots;  // the one piece of shared state that a signal handler forces upon us

extern "C" void remove_temporaries(int signal) {
  for (Slot& slot : g_slots)
    if (slot.live.load()) ::unlink(slot.name.data());
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

void remember(const std::string& name) {
  static const bool installed = [] {
    for (const int signal : {SIGINT, SIGTERM, SIGHUP})
      if (std::signal(signal, remove_temporaries) == SIG_IGN) std::signal(signal, SIG_IGN);
    return true;
  }();
  (void)installed;
  if (name.size() + 1 > kLongest) return;
  for (Slot& slot : g_slots) {
    bool expected = false;
    if (!slot.taken.compare_exchange_strong(expected, true)) continue;
    std::memcpy(slot.name.data(), name.c_str(), name.size() + 1);
    slot.live = true;
    return;
  }
}

void forget(const std::string& name) {
  for (Slot& slot : g_slots)
    if (slot.live.load() && name == slot.name.data()) slot.live = false, slot.taken = false;
}

void refuse_input(const std::string& path, const std::vector<std::string>& inputs) {
  struct stat output {};
  if (::stat(path.c_str(), &output) != 0) return;
  if (S_ISDIR(output.st_mode)) throw cannot_write(path, "it is a folder");
  for (const std::string& input : inputs) {
    struct stat info {};
    if (::stat(input.c_str(), &info) == 0 && info.st_dev == output.st_dev && info.st_ino == output.st_ino)
      throw UsageError(path + ": the output is the input " + input + "; an input is never overwritten");
  }
}

void sync_folder(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  const int handle = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (handle < 0) return;
  ::fsync(handle);
  ::close(handle);
}

}  // namespace

OutputFile::OutputFile(std::string path, const std::vector<std::string>& inputs) : path_(std::move(path)) {
  if (path_ == "-") {
    path_ = "standard output";
    file_ = STDOUT_FILENO;
    return;
  }
  if (path_.empty()) throw UsageError("the output has no name");
  refuse_input(path_, inputs);
  // A link is followed: what it points at is replaced, the link stays.
  std::error_code error;
  if (std::filesystem::is_symlink(path_, error)) {
    const std::filesystem::path target = std::filesystem::canonical(path_, error);
    if (!error) path_ = target.string();
  }
  struct stat info {};
  if (::stat(path_.c_str(), &info) == 0) {
    if (::access(path_.c_str(), W_OK) != 0) throw cannot_write(path_, std::strerror(errno));
    if (!S_ISREG(info.st_mode)) {  // a device is written to, never replaced
      file_ = ::open(path_.c_str(), O_WRONLY | O_CLOEXEC);
      if (file_ < 0) throw cannot_write(path_, std::strerror(errno));
      return;
    }
    mode_ = info.st_mode & 0777;
  }
  // A file without a name vanishes with its writer, however that ends; not every file system has such.
  const std::filesystem::path folder = std::filesystem::path(path_).parent_path();
  file_ = ::open(folder.empty() ? "." : folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file_ < 0) {
    temporary_ = path_ + ".trunnion-XXXXXX";
    file_ = ::mkostemp(temporary_.data(), O_CLOEXEC);
    if (file_ < 0) throw cannot_write(path_, std::strerror(errno));
    remember(temporary_);
  }
  replaces_ = true;
  const mode_t mask = ::umask(0);
  ::umask(mask);
  ::fchmod(file_, mode_ != 0 ? mode_ : 0666 & ~mask);
}

OutputFile::~OutputFile() {
  if (file_ > STDERR_FILENO) ::close(file_);
  if (!temporary_.empty()) {
    ::unlink(temporary_.c_str());
    forget(temporary_);
  }
}

void OutputFile::append(std::string_view text) {
  buffer_ += text;
  if (replaces_ && buffer_.size() >= (std::size_t{1} << 20)) flush();
}

void OutputFile::flush() {
  std::size_t done = 0;
  while (done < buffer_.size()) {
    const ssize_t put = ::write(file_, buffer_.data() + done, buffer_.size() - done);
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) throw cannot_write(path_, std::strerror(errno));
    done += static_cast<std::size_t>(put);
  }
  buffer_.clear();
}

std::string OutputFile::written() {
  flush();
  return temporary_.empty() ? "/proc/self/fd/" + std::to_string(file_) : temporary_;
}

void OutputFile::settle() {
  flush();
  if (replaces_ && ::fsync(file_) != 0) throw cannot_write(path_, std::strerror(errno));
}

void OutputFile::stand_beside() {
  if (!replaces_) return;
  if (temporary_.empty()) take_name();
  if (::close(std::exchange(file_, -1)) != 0) throw cannot_write(path_, std::strerror(errno));
}

void OutputFile::take_name() {
  const std::string unnamed = "/proc/self/fd/" + std::to_string(file_);
  for (int attempt = 0;; ++attempt) {
    std::string name = path_ + ".trunnion-" + std::to_string(::getpid()) + "-" + std::to_string(attempt);
    remember(name);
    if (::linkat(AT_FDCWD, unnamed.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0) {
      temporary_ = std::move(name);
      return;
    }
    const int why = errno;
    forget(name);
    if (why != EEXIST) throw cannot_write(path_, std::strerror(why));
  }
}

void OutputFile::move() {
  if (!replaces_) return;
  if (std::rename(temporary_.c_str(), path_.c_str()) != 0) throw cannot_write(path_, std::strerror(errno));
  forget(temporary_);
  temporary_.clear();
}

void OutputFile::commit() {
  settle();
  stand_beside();
  move();
  if (replaces_) sync_folder(path_);
}

void write_whole(const std::string& path, std::string_view text, const std::vector<std::string>& inputs) {
  OutputFile file(path, inputs);
  file.append(text);
  file.commit();
}

OutputFolder::OutputFolder(std::string folder, std::vector<std::string> inputs)
    : folder_(std::move(folder)), inputs_(std::move(inputs)) {}

void OutputFolder::add(std::string name, std::string text) { files_.emplace_back(std::move(name), std::move(text)); }

void OutputFolder::commit() {
  namespace fs = std::filesystem;
  std::vector<fs::path> made;
  const auto make_folder = [&](const fs::path& path) {
    std::error_code error;
    if (fs::is_directory(path, error)) return;
    if (!fs::create_directory(path, error))
      throw cannot_write(path.string(), error ? error.message() : "a file stands there");
    made.push_back(path);
  };
  try {
    make_folder(folder_);
    std::vector<std::unique_ptr<OutputFile>> whole;
    for (const auto& [name, text] : files_) {
      const fs::path path = fs::path(folder_) / name;
      if (path.parent_path() != fs::path(folder_)) make_folder(path.parent_path());
      whole.push_back(std::make_unique<OutputFile>(path.string(), inputs_));
      whole.back()->append(text);
    }
    // Whatever fails for want of room fails before the first is moved; and the moves follow one another at once, so
    // that hardly a kill finds a set half old, half new.
    for (const auto& file : whole) file->settle();
    for (const auto& file : whole) file->stand_beside();
    for (const auto& file : whole) file->move();
    for (const auto& file : whole) sync_folder(file->path_);
  } catch (...) {
    std::error_code ignored;
    for (auto path = made.rbegin(); path != made.rend(); ++path) fs::remove(*path, ignored);  // only if empty
    throw;
  }
}

}  // namespace trunnion
