#include "cpplus/core/option_list.h"

#include <gmock/gmock.h>

#include "cpplus/core/error.h"

namespace cpplus {
namespace {

struct InnerOptions {
  double radius_m = 0.1;
  bool dilate = true;

  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("radius_m", radius_m, "Radius.");
    visitor("dilate", dilate, "Dilate.");
  }
};

struct OuterOptions {
  int count = 3;
  InnerOptions inner;
  std::string name = "a b";

  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("count", count, "Count.");
    visitor.group("inner", inner);
    visitor("name", name, "Name.");
  }
};

std::vector<std::string> paths_and_values(const std::vector<OptionField>& fields) {
  std::vector<std::string> texts;
  for (const OptionField& field : fields) texts.push_back(field.path + "=" + option_text(field));
  return texts;
}

TEST(OptionList, ListsFieldsInOrderWithGroups) {
  OuterOptions options;
  EXPECT_THAT(paths_and_values(list_options(options)),
              testing::ElementsAre("count=3", "inner.radius_m=0.1", "inner.dilate=true", "name=a b"));
  EXPECT_EQ(list_options(options, "refine")[1].path, "refine.inner.radius_m");
  EXPECT_EQ(list_options(options)[1].doc, "Radius.");
}

TEST(OptionList, SetsEveryType) {
  OuterOptions options;
  const std::vector<OptionField> fields = list_options(options);
  set_option(fields[0], "count", "-7");
  set_option(fields[1], "radius", "2.5e-3");
  set_option(fields[2], "dilate", "false");
  set_option(fields[3], "name", "");
  EXPECT_EQ(options.count, -7);
  EXPECT_EQ(options.inner.radius_m, 2.5e-3);
  EXPECT_FALSE(options.inner.dilate);
  EXPECT_EQ(options.name, "");
}

TEST(OptionList, TextOfANumberReadsBackExactly) {
  OuterOptions options;
  const std::vector<OptionField> fields = list_options(options);
  for (const double value : {1.0 / 3.0, 1e300, -0.0, 5e-324, 123456789.123456789}) {
    options.inner.radius_m = value;
    const std::string text = option_text(fields[1]);
    options.inner.radius_m = 99.0;
    set_option(fields[1], "radius", text);
    EXPECT_EQ(options.inner.radius_m, value) << text;
  }
}

TEST(OptionList, WrongTypesNameTheFieldAndKeepTheValue) {
  OuterOptions options;
  const std::vector<OptionField> fields = list_options(options);
  const auto message = [&](size_t i, const std::string& text) -> std::string {
    try {
      set_option(fields[i], "--x", text);
    } catch (const UsageError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(message(0, "1.5"), "--x must be a whole number, got '1.5'");
  EXPECT_EQ(message(0, "99999999999"), "--x must be a whole number, got '99999999999'");
  EXPECT_EQ(message(0, ""), "--x must be a whole number, got ''");
  EXPECT_EQ(message(1, "1,5"), "--x must be a number, got '1,5'");
  EXPECT_EQ(message(1, "2m"), "--x must be a number, got '2m'");
  EXPECT_EQ(message(2, "maybe"), "--x must be true or false, got 'maybe'");
  EXPECT_EQ(options.count, 3);
  EXPECT_EQ(options.inner.radius_m, 0.1);
  EXPECT_TRUE(options.inner.dilate);
}

}  // namespace
}  // namespace cpplus
