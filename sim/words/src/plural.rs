//! Selects the plural form for a count with the expression in a catalogue's header `Plural-Forms`,
//! a C expression in `n` (GNU gettext manual, *Additional functions for plural forms*).

use anyhow::Context;

/// Counts that cover every plural form of the languages listed in gettext's manual: all below the
/// first, and the second.
const SAMPLES: [u64; 2] = [201, 1_000_000];

/// The operators, lowest precedence first; within a row the longer ones first.
const OPERATORS: [&[(&str, Operation)]; 6] = [
    &[("||", |a, b| Some(u64::from(a != 0 || b != 0)))],
    &[("&&", |a, b| Some(u64::from(a != 0 && b != 0)))],
    &[("==", |a, b| Some(u64::from(a == b))), ("!=", |a, b| Some(u64::from(a != b)))],
    &[
        ("<=", |a, b| Some(u64::from(a <= b))),
        (">=", |a, b| Some(u64::from(a >= b))),
        ("<", |a, b| Some(u64::from(a < b))),
        (">", |a, b| Some(u64::from(a > b))),
    ],
    &[("+", u64::checked_add), ("-", u64::checked_sub)],
    &[("*", u64::checked_mul), ("/", u64::checked_div), ("%", u64::checked_rem)],
];

/// An operation on two numbers; `None` if the result is undefined or out of range.
type Operation = fn(u64, u64) -> Option<u64>;

/// The plural rule of a catalogue.
#[derive(Clone, Debug)]
pub(super) struct PluralForms {
    count: usize,
    rule: PluralExpression,
}

#[derive(Clone, Debug)]
enum PluralExpression {
    Count,
    Number(u64),
    Not(Box<Self>),
    Operation(Operation, Box<[Self; 2]>),
    Choice(Box<[Self; 3]>),
}

impl PluralForms {
    /// Parses an expression that selects one of `count` forms.
    ///
    /// # Errors
    /// If it cannot be parsed, or if a count selects a form that does not exist, or no count
    /// selects one that does.
    pub(super) fn parse(count: usize, expression: &str) -> anyhow::Result<Self> {
        let mut parser = Parser { text: expression, rest: expression.trim_start() };
        let rule = parser.choice().with_context(|| format!("Plural-Forms: plural={expression}"))?;
        anyhow::ensure!(parser.rest.is_empty(), "Plural-Forms: plural={expression}: {}", parser.place("an operator"));
        let forms = Self { count, rule };
        let [whole, large] = SAMPLES;
        let mut chosen = vec![false; count];
        for n in (0..whole).chain([large]) {
            let form = forms.find_form(n);
            let form =
                form.with_context(|| format!("Plural-Forms: nplurals={count}; n = {n} has none of these forms"))?;
            chosen[form] = true;
        }
        if let Some(unused) = chosen.iter().position(|chosen| !chosen) {
            anyhow::bail!("Plural-Forms: nplurals={count}; no n has form {unused}");
        }
        Ok(forms)
    }

    /// Returns the index of the form for a count.
    pub(super) fn find_form(&self, n: u64) -> Option<usize> {
        let form = usize::try_from(self.rule.evaluate(n)?).ok()?;
        (form < self.count).then_some(form)
    }
}

impl PluralExpression {
    fn evaluate(&self, n: u64) -> Option<u64> {
        match self {
            Self::Count => Some(n),
            Self::Number(number) => Some(*number),
            Self::Not(operand) => operand.evaluate(n).map(|value| u64::from(value == 0)),
            Self::Operation(operation, operands) => {
                let [left, right] = operands.as_ref();
                operation(left.evaluate(n)?, right.evaluate(n)?)
            }
            Self::Choice(parts) => {
                let [condition, then, otherwise] = parts.as_ref();
                if condition.evaluate(n)? != 0 { then.evaluate(n) } else { otherwise.evaluate(n) }
            }
        }
    }
}

struct Parser<'a> {
    text: &'a str,
    rest: &'a str,
}

impl Parser<'_> {
    /// Parses `condition ? then : otherwise`, or an expression of higher precedence.
    fn choice(&mut self) -> anyhow::Result<PluralExpression> {
        let condition = self.operation(&OPERATORS)?;
        if !self.take("?") {
            return Ok(condition);
        }
        let then = self.choice()?;
        self.expect(":")?;
        Ok(PluralExpression::Choice(Box::new([condition, then, self.choice()?])))
    }

    /// Parses operands separated by operators of the first row, left-associative.
    fn operation(&mut self, rows: &[&[(&str, Operation)]]) -> anyhow::Result<PluralExpression> {
        let Some((row, tighter)) = rows.split_first() else { return self.operand() };
        let mut left = self.operation(tighter)?;
        while let Some((_, operation)) = row.iter().find(|(symbol, _)| self.take(symbol)) {
            left = PluralExpression::Operation(*operation, Box::new([left, self.operation(tighter)?]));
        }
        Ok(left)
    }

    fn operand(&mut self) -> anyhow::Result<PluralExpression> {
        if self.take("n") {
            return Ok(PluralExpression::Count);
        }
        if self.take("!") {
            return Ok(PluralExpression::Not(Box::new(self.operand()?)));
        }
        if self.take("(") {
            let inner = self.choice()?;
            self.expect(")")?;
            return Ok(inner);
        }
        let digits = self.rest.bytes().take_while(u8::is_ascii_digit).count();
        let (number, rest) = self.rest.split_at(digits);
        let number = number.parse().map_err(|_| anyhow::anyhow!(self.place("n, a number, \"!\" or \"(\"")))?;
        self.rest = rest.trim_start();
        Ok(PluralExpression::Number(number))
    }

    /// Consumes a symbol and the spaces after it, if it comes next.
    fn take(&mut self, symbol: &str) -> bool {
        let after = self.rest.strip_prefix(symbol).map(str::trim_start);
        self.rest = after.unwrap_or(self.rest);
        after.is_some()
    }

    fn expect(&mut self, symbol: &str) -> anyhow::Result<()> {
        anyhow::ensure!(self.take(symbol), self.place(&format!("\"{symbol}\"")));
        Ok(())
    }

    /// Describes the expected token and its position.
    fn place(&self, expected: &str) -> String {
        format!("expected {expected} at character {}", self.text.len() - self.rest.len() + 1)
    }
}

#[cfg(test)]
mod tests {
    //! The headers that gettext's manual and its catalogues publish. Every count must get the form
    //! of its language, and a malformed header must be refused.

    use super::*;

    const SLAVIC: &str = "n%10==1 && n%100!=11 ? 0 : n%10>=2 && n%10<=4 && (n%100<10 || n%100>=20) ? 1 : 2";

    fn forms(count: usize, expression: &str, counts: &[u64]) -> Vec<usize> {
        let forms = PluralForms::parse(count, expression).unwrap();
        counts.iter().map(|n| forms.find_form(*n).unwrap()).collect()
    }

    #[test]
    fn published_headers_choose_their_languages_forms() {
        let (polish, arabic) = (
            "(n==1 ? 0 : n%10>=2 && n%10<=4 && (n%100<10 || n%100>=20) ? 1 : 2)",
            "n==0 ? 0 : n==1 ? 1 : n==2 ? 2 : n%100>=3 && n%100<=10 ? 3 : n%100>=11 ? 4 : 5",
        );
        assert_eq!(forms(2, "n != 1", &[0, 1, 2, 21]), [1, 0, 1, 1], "English and German");
        assert_eq!(forms(2, "n>1", &[0, 1, 2, 1_000_000]), [0, 0, 1, 1], "French");
        assert_eq!(
            forms(3, "(n==0 || n==1) ? 0 : n!=0 && n%1000000==0 ? 1 : 2", &[0, 1, 2, 1_000_000]),
            [0, 0, 2, 1],
            "French by the CLDR"
        );
        assert_eq!(forms(1, "0", &[0, 1, 2]), [0, 0, 0], "Japanese");
        assert_eq!(forms(3, polish, &[1, 2, 5, 12, 22, 112, 122]), [0, 1, 2, 2, 1, 2, 1], "Polish");
        assert_eq!(forms(3, SLAVIC, &[1, 11, 21, 2, 12, 22, 0, 111]), [0, 2, 0, 1, 2, 1, 2, 2], "Russian");
        assert_eq!(forms(6, arabic, &[0, 1, 2, 3, 11, 100, 103]), [0, 1, 2, 3, 4, 5, 3], "Arabic");
    }

    #[test]
    fn operators_bind_as_in_c() {
        for (expression, expected) in [
            ("1+2*3-4", 3),
            ("7/2%2", 1),
            ("10-4-3", 3),
            ("1<2==1", 1),
            ("1||0&&0", 1),
            ("!n", 1),
            ("!(n==0)+5*!n", 5),
            ("n?1:n==0?2:3", 2),
            (" ( 4 ) ", 4),
        ] {
            let mut parser = Parser { text: expression, rest: expression.trim_start() };
            assert_eq!(parser.choice().unwrap().evaluate(0), Some(expected), "{expression}");
        }
    }

    #[test]
    fn a_broken_expression_is_refused_with_its_place() {
        for (count, expression, expected) in [
            (2, "n !=", "expected n, a number, \"!\" or \"(\" at character 5"),
            (2, "", "character 1"),
            (2, "n = 1", "expected an operator at character 3"),
            (2, "n ! 1", "expected an operator at character 3"),
            (2, "(n != 1", "expected \")\" at character 8"),
            (2, "n ? 1", "expected \":\" at character 6"),
            (2, "m != 1", "character 1"),
            (2, "99999999999999999999", "character 1"),
            (2, "n", "n = 2 has none of these forms"),
            (2, "n - 1", "n = 0 has none"),
            (2, "1 / n", "n = 0 has none"),
            (3, "n != 1", "no n has form 2"),
            (2, SLAVIC, "n = 0 has none"),
        ] {
            let refused = format!("{:#}", PluralForms::parse(count, expression).unwrap_err());
            assert!(refused.contains("Plural-Forms") && refused.contains(expected), "{expression}: {refused}");
        }
    }
}
