//! Which form of a sentence goes with a count: the C expression of `Plural-Forms` in a PO file.

use anyhow::{Context, bail};

/// Deepest that parentheses and conditions may nest; the richest language needs six.
const DEEPEST: u32 = 32;

/// Operators by how tightly they bind, the loosest first.
const OPERATORS: [&[&str]; 5] = [&["||"], &["&&"], &["==", "!="], &["<=", ">=", "<", ">"], &["%"]];

/// A rule of plurals, read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum PluralRule {
    Count,
    Number(u64),
    Both(&'static str, Box<(Self, Self)>),
    Choice(Box<(Self, Self, Self)>),
}

impl PluralRule {
    /// Reads `n != 1` and its like.
    ///
    /// # Errors
    /// When it is no such expression.
    pub(super) fn read(text: &str) -> anyhow::Result<Self> {
        let mut rest = Rest { text, depth: 0 };
        let rule = rest.choice().with_context(|| format!("Plural-Forms: \"{text}\""))?;
        if !rest.text.trim().is_empty() {
            bail!("Plural-Forms: \"{text}\": nothing may stand after it, and \"{}\" does", rest.text);
        }
        Ok(rule)
    }

    /// The number of the form that goes with a count.
    pub(super) fn form(&self, count: u64) -> usize {
        usize::try_from(self.value(count)).unwrap_or(usize::MAX)
    }

    fn value(&self, n: u64) -> u64 {
        match self {
            Self::Count => n,
            Self::Number(number) => *number,
            Self::Both(sign, sides) => combined(sign, sides.0.value(n), sides.1.value(n)),
            Self::Choice(parts) if parts.0.value(n) != 0 => parts.1.value(n),
            Self::Choice(parts) => parts.2.value(n),
        }
    }
}

fn combined(sign: &str, left: u64, right: u64) -> u64 {
    match sign {
        "%" => left.checked_rem(right).unwrap_or(0),
        "||" => u64::from(left != 0 || right != 0),
        "&&" => u64::from(left != 0 && right != 0),
        "==" => u64::from(left == right),
        "!=" => u64::from(left != right),
        "<=" => u64::from(left <= right),
        ">=" => u64::from(left >= right),
        "<" => u64::from(left < right),
        _ => u64::from(left > right),
    }
}

/// What is still to be read.
struct Rest<'a> {
    text: &'a str,
    depth: u32,
}

impl Rest<'_> {
    fn takes(&mut self, sign: &str) -> bool {
        let rest = self.text.trim_start().strip_prefix(sign);
        self.text = rest.unwrap_or(self.text);
        rest.is_some()
    }

    fn choice(&mut self) -> anyhow::Result<PluralRule> {
        self.depth += 1;
        if self.depth > DEEPEST {
            bail!("it nests too deeply");
        }
        let first = self.level(0)?;
        let rule = if self.takes("?") {
            let yes = self.choice()?;
            if !self.takes(":") {
                bail!("a \":\" is missing before \"{}\"", self.text);
            }
            PluralRule::Choice(Box::new((first, yes, self.choice()?)))
        } else {
            first
        };
        self.depth -= 1;
        Ok(rule)
    }

    fn level(&mut self, level: usize) -> anyhow::Result<PluralRule> {
        let Some(signs) = OPERATORS.get(level) else { return self.atom() };
        let mut left = self.level(level + 1)?;
        while let Some(sign) = signs.iter().find(|sign| self.takes(sign)) {
            left = PluralRule::Both(sign, Box::new((left, self.level(level + 1)?)));
        }
        Ok(left)
    }

    fn atom(&mut self) -> anyhow::Result<PluralRule> {
        if self.takes("n") {
            return Ok(PluralRule::Count);
        }
        if self.takes("(") {
            let inner = self.choice()?;
            return if self.takes(")") { Ok(inner) } else { bail!("a \")\" is missing before \"{}\"", self.text) };
        }
        let text = self.text.trim_start();
        let digits = text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let (number, rest) = text.split_at(digits);
        self.text = rest;
        number
            .parse()
            .map(PluralRule::Number)
            .with_context(|| format!("a number, n or \"(\" is needed before \"{rest}\""))
    }
}

#[cfg(test)]
mod tests {
    //! Rules as translators' tools write them, for languages with one, two and three forms. Fails when a count gets
    //! another form than the language gives it.

    use super::*;

    fn forms(rule: &str, counts: &[u64]) -> Vec<usize> {
        let rule = PluralRule::read(rule).unwrap();
        counts.iter().map(|n| rule.form(*n)).collect()
    }

    #[test]
    fn known_languages_have_their_forms() {
        assert_eq!(forms("n != 1", &[0, 1, 2, 21]), [1, 0, 1, 1]);
        assert_eq!(forms("(n > 1)", &[0, 1, 2]), [0, 0, 1]);
        assert_eq!(forms("0", &[0, 1, 2]), [0, 0, 0]);
        let polish = "(n==1 ? 0 : n%10>=2 && n%10<=4 && (n%100<10 || n%100>=20) ? 1 : 2)";
        assert_eq!(forms(polish, &[1, 2, 5, 12, 22, 112, 122]), [0, 1, 2, 2, 1, 2, 1]);
    }

    #[test]
    fn what_is_no_rule_is_refused_with_the_place() {
        for broken in ["", "n +", "n ?", "n ? 1", "(n", "n n", "m", &"(".repeat(100)] {
            let refused = format!("{:#}", PluralRule::read(broken).unwrap_err());
            assert!(refused.contains("Plural-Forms"), "{refused}");
        }
        assert_eq!(forms("n % 0", &[3]), [0], "a division by zero is contained");
    }
}
