#include "history/date.h"

#include <gtest/gtest.h>

namespace trunnion {
namespace {

TEST(Date, HasOneFormThatSortsByTime) {
  EXPECT_EQ(normal_date("2026-03-01"), "2026-03-01T00:00:00Z");
  EXPECT_EQ(normal_date("2026-03-01T14:30:05Z"), "2026-03-01T14:30:05Z");
  EXPECT_EQ(short_date("2026-03-01T00:00:00Z"), "2026-03-01");
  EXPECT_EQ(short_date("2026-03-01T14:30:05Z"), "2026-03-01T14:30:05Z");
}

TEST(Date, RefusesWhatNoCalendarHas) {
  for (const char* text : {"", "2026-02-29", "2026-13-01", "2026-3-1", "01.03.2026", "2026-03-01T24:00:00Z",
                           "2026-03-01T14:30:05", "2026-03-01T14:30:05+01:00", "2026-03-01 14:30:05Z"})
    EXPECT_FALSE(normal_date(text)) << text;
  EXPECT_TRUE(normal_date("2028-02-29"));
}

TEST(Date, CountsDays) {
  EXPECT_EQ(days_of("1970-01-02T00:00:00Z"), 1);
  EXPECT_EQ(days_of("2000-03-01T12:00:00Z"), 11017.5);  // 946684800 s at 2000-01-01, and 60 days
}

}  // namespace
}  // namespace trunnion
