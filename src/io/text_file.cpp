#include "io/text_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "error.h"

namespace trunnion {

std::string read_text(const std::string& path, std::size_t most_bytes) {
  const auto fail = [&](const std::string& why) -> InputError { return InputError(path, "cannot be read: " + why); };
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) throw fail(std::strerror(errno));
  struct Closer {
    int file;
    ~Closer() { ::close(file); }
  } const closer{file};
  struct stat info {};
  if (::fstat(file, &info) == 0 && S_ISDIR(info.st_mode)) throw fail("it is a folder");
  constexpr std::size_t kChunk = std::size_t{1} << 20;
  std::string text;
  if (S_ISREG(info.st_mode)) {
    if (static_cast<std::size_t>(info.st_size) > most_bytes)
      throw fail(std::to_string(info.st_size) + " bytes are too many, " + std::to_string(most_bytes) + " is the most");
    text.reserve(static_cast<std::size_t>(info.st_size) + kChunk);  // the read that finds the end asks for room too
  }
  for (;;) {
    const std::size_t have = text.size();
    text.resize(have + kChunk);
    const ssize_t got = ::read(file, text.data() + have, kChunk);
    if (got < 0 && errno == EINTR) {
      text.resize(have);
      continue;
    }
    if (got < 0) throw fail(std::strerror(errno));
    text.resize(have + static_cast<std::size_t>(got));
    if (got == 0) return text;
    if (text.size() > most_bytes) throw fail("it is longer than " + std::to_string(most_bytes) + " bytes");
  }
}

}  // namespace trunnion
