#include "server/formats/formula/formula.h"

#include <gmock/gmock.h>

#include "server/effects/term_order.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::vector<Channel> kCellChannels = {
    {"q1", "mm"},   {"q2", "mm"},    {"x", "mm"},     {"y", "mm"},     {"z", "mm"},
    {"force", "N"}, {"t04", "degC"}, {"t05", "degC"}, {"t10", "degC"}, {"air", "degC"}};

std::vector<std::string> terms(const std::string& text) {
  const auto formula = Formula::parse(text);
  if (!formula) return {formula.error().message};
  const auto candidates = formula->expand(kCellChannels);
  if (!candidates) return {candidates.error().message};
  std::vector<std::string> names;
  for (const auto& term : candidates->terms) names.push_back(effects::notation(term));
  if (!candidates->constant) names.push_back("no constant");
  return names;
}

Error error_of(const std::string& text, const FormulaLimits& limits = {}) {
  const auto formula = Formula::parse(text, limits);
  if (!formula) return formula.error();
  const auto candidates = formula->expand(kCellChannels);
  EXPECT_FALSE(candidates.has_value()) << text;
  return candidates ? Error{} : candidates.error();
}

TEST(Formula, ExpandsTheShortForms) {
  EXPECT_THAT(terms("q ~ x + x^2 + T"), ElementsAre("x", "x^2", "t04", "t05", "t10"));
  EXPECT_THAT(terms("q1 ~ F + F^2 + F^3"), ElementsAre("force", "force^2", "force^3"));
  EXPECT_THAT(terms("q1 ~ t04..t05"), ElementsAre("t04", "t05"));
  EXPECT_THAT(terms("q1~air"), ElementsAre("air"));
}

TEST(Formula, PolyIsAllMonomialsUpToTheDegree) {
  EXPECT_THAT(terms("q ~ poly(x, y, 2)"), ElementsAre("x", "y", "x^2", "x:y", "y^2"));
  EXPECT_EQ(terms("q ~ poly(x, y, z, 3)").size(), 19u);  // the published study's 19 distinct ones
  EXPECT_EQ(terms("q ~ poly(x, y, z, 3) + F + F^2 + F^3 + T + air").size(), 26u);
}

TEST(Formula, CrossesAndStars) {
  EXPECT_THAT(terms("q ~ x:t04"), ElementsAre("x:t04"));
  EXPECT_THAT(terms("q ~ x*F"), ElementsAre("x", "force", "x:force"));
  EXPECT_THAT(terms("q ~ (x + x^2):(t04 + t05)"),
              ElementsAre("x:t04", "x:t05", "x^2:t04", "x^2:t05"));
  EXPECT_THAT(terms("q ~ (1 + x):F"), ElementsAre("force", "x:force"));
  EXPECT_THAT(terms("q ~ x:x"), ElementsAre("x^2"));
}

TEST(Formula, RemovesWhatStandsBefore) {
  EXPECT_THAT(terms("q ~ T - t05"), ElementsAre("t04", "t10"));
  EXPECT_THAT(terms("q ~ poly(x, 3) - x^2 + x^2"), ElementsAre("x", "x^3", "x^2"));
  EXPECT_THAT(terms("q ~ x - 1"), ElementsAre("x", "no constant"));
  EXPECT_THAT(terms("q ~ -1 + x"), ElementsAre("x", "no constant"));
  EXPECT_THAT(error_of("q ~ x - y").message,
              HasSubstr("nothing to remove: y does not stand before this, column 9"));
}

TEST(Formula, TakesEffectsWithTheirQuantities) {
  EXPECT_THAT(terms("q ~ rate(T, 5 min)"),
              ElementsAre("rate(t04, 300 s)", "rate(t05, 300 s)", "rate(t10, 300 s)"));
  EXPECT_THAT(terms("q ~ x:lag(t04, 1830 s)"), ElementsAre("x:lag(t04, 1830 s)"));
}

TEST(Formula, TakesEveryEffectOfTheCatalogueAndPrintsItBack) {
  for (const std::string text : {"play(q1, 85 nm)", "heat(q1, 1200 s)", "sin(x, 316.4 nm)",
                                 "cos(x, 316.4 nm)", "sin_t(600 s)", "step(14210 s)", "drift()"}) {
    EXPECT_THAT(terms("q2 ~ " + text), ElementsAre(text));
    const auto term = parse_term(text);
    ASSERT_TRUE(term.has_value()) << text;
    EXPECT_EQ(effects::notation(*term), text);
  }
  EXPECT_THAT(terms("q2 ~ sin(x, 0.3164 um)"), ElementsAre("sin(x, 316.4 nm)"));
}

TEST(Formula, LetsTheTermsOfAMotorCoordinateObserveItsPath) {
  EXPECT_THAT(terms("q1 ~ x + play(q1, 85 nm) + heat(q1, 20 min)"),
              ElementsAre("x", "play(q1, 85 nm)", "heat(q1, 1200 s)"));
  EXPECT_THAT(error_of("q1 ~ sin(q1, 20 um)").message, HasSubstr("stands among its own terms"));
}

TEST(Formula, RefusesAnEffectOnAChannelOfAnotherUnit) {
  const Error error = error_of("q1 ~ sin(t04, 316.4 nm)");
  EXPECT_EQ(error.reason, "BAD_UNIT");
  EXPECT_THAT(error.message, HasSubstr("observes t04_degC: expected a channel of lengths"));
}

TEST(Formula, OfferedTwiceIsOfferedOnce) {
  EXPECT_THAT(terms("q ~ x + x + poly(x, 2)"), ElementsAre("x", "x^2"));
}

TEST(Formula, KnowsItsOutputs) {
  EXPECT_THAT(Formula::parse("q ~ x")->expand(kCellChannels)->outputs, ElementsAre("q1", "q2"));
  EXPECT_THAT(Formula::parse("z + q2 ~ x")->expand(kCellChannels)->outputs, ElementsAre("z", "q2"));
  EXPECT_THAT(error_of("q + q1 ~ x").message, HasSubstr("stands twice"));
  EXPECT_THAT(error_of("q1 ~ q1 + x").message,
              HasSubstr("the output q1 stands among its own terms"));
}

TEST(Formula, PrintsCanonically) {
  EXPECT_EQ(Formula::parse(" q~poly(x,y , 3)+F^2-t05+(x+1):T+rate(t04,5 min)")->canonical(),
            "q ~ poly(x, y, 3) + F^2 - t05 + (x + 1):T + rate(t04, 5 min)");
}

struct Bad {
  std::string text, reason, part;
};

TEST(Formula, SaysWhatIsWrongAndWhere) {
  const std::vector<Bad> table = {
      {"", "BAD_FORMULA", "expected an output"},
      {"q", "BAD_FORMULA", "found the end, expected ~"},
      {"q ~", "BAD_FORMULA", "column 4"},
      {"q ~ x +", "BAD_FORMULA", "found the end, expected a channel"},
      {"q ~ x ? y", "BAD_FORMULA",
       "'?' has no meaning in a formula, column 7:\n  q ~ x ? y\n        ^"},
      {"q ~ x y", "BAD_FORMULA", "found 'y', expected + - * : or the end"},
      {"q ~ (x + y", "BAD_FORMULA", "expected )"},
      {"q ~ x^2.5", "BAD_FORMULA", "a whole power from 1 to 20"},
      {"q ~ x^0", "BAD_FORMULA", "a whole power"},
      {"q ~ (x + y)^2", "BAD_FORMULA", "write a product as a:b"},
      {"q ~ 2", "BAD_FORMULA", "the only number that is a term is 1"},
      {"q ~ T^2", "BAD_FORMULA", "several channels"},
      {"q ~ t99", "UNKNOWN_CHANNEL", "unknown channel 't99', the file has: q1 q2 x"},
      {"q3 ~ x", "UNKNOWN_CHANNEL", "unknown channel 'q3'"},
      {"q ~ poly(x, 300)", "BAD_FORMULA", "the degree of poly"},
      {"q ~ poly(x, x, 2)", "BAD_FORMULA", "x stands twice in poly"},
      {"q ~ t10..t04", "BAD_FORMULA", "runs from one number to a higher"},
      {"q ~ wobble(x)", "UNKNOWN_EFFECT", "known are lag(channel, tau s)"},
      {"q ~ lag(t04, 30 nm)", "BAD_EFFECT", "tau is in 'nm', expected s"},
      {"q ~ lag(lag(t04, 1 s), 1 s)", "BAD_FORMULA", "observes channels"},
      {"q ~ datum(2)", "BAD_FORMULA", "added by the fit itself"},
      {"q ~ x + 1e999", "BAD_FORMULA", "no number within double precision"},
  };
  for (const auto& bad : table) {
    const Error error = error_of(bad.text);
    EXPECT_EQ(error.reason, bad.reason) << bad.text << "\n" << error.message;
    EXPECT_THAT(error.message, HasSubstr(bad.part)) << bad.text;
    EXPECT_EQ(error.code, ErrorCode::invalid_argument);
  }
}

TEST(Formula, OfAHundredThousandTermsIsRefused) {
  std::string text = "q ~ x";
  for (int i = 0; i < 100000; ++i) text += " + x";
  const Error error = error_of(text);
  EXPECT_EQ(error.reason, "FORMULA_TOO_LARGE");
  EXPECT_THAT(error.message, HasSubstr("more than 2000 terms"));
  EXPECT_LT(error.message.size(), 400u);
}

TEST(Formula, ThatExplodesIsRefusedBeforeItDoes) {
  EXPECT_EQ(error_of("q ~ poly(x, y, z, 20):poly(x, y, z, 20)").reason, "FORMULA_TOO_LARGE");
  std::string nested = "q ~ ";
  for (int i = 0; i < 1000; ++i) nested += "(";
  EXPECT_EQ(error_of(nested).reason, "FORMULA_TOO_LARGE");
  std::string repeated = "q ~ x";
  for (int i = 0; i < 1999; ++i) repeated += " + poly(x, y, z, 18)";
  EXPECT_EQ(error_of(repeated).reason, "FORMULA_TOO_LARGE");
  EXPECT_EQ(error_of(std::string(2 << 20, 'x')).reason, "FORMULA_TOO_LARGE");
}

TEST(ParseTerm, ReadsWhatNotationPrints) {
  for (const auto* text :
       {"1", "x", "x^2:t07", "rate(t07, 300 s)", "x:lag(t07, 1830 s)", "datum(2)"}) {
    const auto term = parse_term(text);
    ASSERT_TRUE(term.has_value()) << text;
    EXPECT_EQ(effects::notation(*term), text);
  }
  for (const auto* text : {"", "x + y", "poly(x, 2)", "datum(x)", "datum(1.5)", "x:", "2"})
    EXPECT_FALSE(parse_term(text).has_value()) << text;
}

// Four points, two thermometers of the robot, one of the instrument and the air; x alone explains
// q1 but for what goes with t04.
Dataset with_parts(const std::string& parts) {
  std::string csv = parts.empty() ? "" : "# parts: " + parts + "\n";
  csv += "q1_mm,x_mm,t04_degC,t05_degC,t10_degC,air_degC\n";
  for (int i = 0; i < 24; ++i) {
    const double x = 0.1 * i, t04 = 20 + (i * 7 % 5) * 0.1, t05 = 20 + (i * 11 % 7) * 0.1;
    const double t10 = 20 + (i * 5 % 9) * 0.1, air = 21 + (i * 3 % 4) * 0.1;
    csv += number_text(x + 1e-4 * t04 + 2e-4 * t10 + 1e-7 * (i * i % 5)) + "," + number_text(x) +
           "," + number_text(t04) + "," + number_text(t05) + "," + number_text(t10) + "," +
           number_text(air) + "\n";
  }
  auto data = read_dataset_csv(csv, "parts.csv");
  EXPECT_TRUE(data) << (data ? "" : data.error().message);
  return data ? std::move(*data) : Dataset{};
}
const std::string kParts = "t04=robot t05=robot t10=instrument air=air";

TEST(Formula, RStandsForTheThermometersOnTheRobot) {
  const auto named = [](const std::string& text, const Dataset& data) {
    const auto candidates = Formula::parse(text)->expand(data);
    std::vector<std::string> names;
    if (!candidates) return std::vector<std::string>{candidates.error().message};
    for (const auto& term : candidates->terms) names.push_back(effects::notation(term));
    return names;
  };
  EXPECT_THAT(named("q ~ x + R", with_parts(kParts)), ElementsAre("x", "t04", "t05"));
  EXPECT_THAT(named("q ~ x + x:R", with_parts(kParts)), ElementsAre("x", "x:t04", "x:t05"));
  EXPECT_THAT(named("q ~ rate(R, 300 s)", with_parts(kParts)),
              ElementsAre("rate(t04, 300 s)", "rate(t05, 300 s)"));
  EXPECT_THAT(named("q ~ x + R", with_parts("")),
              ElementsAre(HasSubstr("add a line '# parts: t05=robot t01=instrument'")));
  EXPECT_THAT(named("q ~ x + R", with_parts("t04=instrument")),
              ElementsAre(HasSubstr("declares none of these channels with part = \"robot\"")));
  EXPECT_EQ(Formula::parse("q~x+R")->canonical(), "q ~ x + R");
}

TEST(Formula, AFitWarnsOfThermometersThatAreNotOnTheRobot) {
  const auto warnings = [](const std::string& formula, const std::string& parts) {
    calibration::FitOptions options;
    options.select = calibration::Select::all;
    const auto model = fit_formula(with_parts(parts), formula, options);
    EXPECT_TRUE(model) << (model ? "" : model.error().message);
    return model ? model->warnings : std::vector<std::string>();
  };
  const auto said = HasSubstr("thermometers of the instrument are in the model: t10");
  EXPECT_THAT(warnings("q ~ x + T", kParts), testing::Contains(said));
  EXPECT_THAT(warnings("q ~ x + R", kParts),
              testing::Not(testing::Contains(HasSubstr("thermometers of"))));
  EXPECT_THAT(warnings("q ~ x + T", ""),
              testing::Not(testing::Contains(HasSubstr("thermometers of"))));
  EXPECT_THAT(warnings("x ~ q1 + t10", kParts),
              testing::Not(testing::Contains(HasSubstr("thermometers of"))))
      << "an instrument's own model may have them";
}

}  // namespace
}  // namespace driftwise::formats
