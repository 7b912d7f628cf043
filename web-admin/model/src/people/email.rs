//! Email addresses: normalization, and validation by the rules of the mail library.

use email_address::EmailAddress;
use unicode_normalization::UnicodeNormalization;
use uuid::Uuid;

use crate::single_line_text::{is_invisible, is_strange};

/// Maximum length of an address, in bytes (RFC 5321, section 4.5.3.1.3, less the angle brackets).
const LONGEST_ADDRESS: usize = 254;

/// Domains of stored addresses that are none: of people without an address, of guests, of erased
/// people. RFC 2606 reserves `.invalid`.
const ABSENT_DOMAINS: [&str; 3] = ["@no-address.invalid", "@guest.invalid", "@erased.invalid"];

/// Returns what is stored instead of an address for a person who has none. `unique` is not used
/// twice.
#[must_use]
pub fn make_absent_email(unique: Uuid) -> String {
    format!("{}{}", unique.simple(), ABSENT_DOMAINS[0])
}

/// Returns a stored address, or `None` if the person has none.
#[must_use]
pub fn present_email(stored: &str) -> Option<&str> {
    let is_absent = ABSENT_DOMAINS.iter().any(|domain| stored.ends_with(domain));
    (!is_absent).then_some(stored)
}

/// Returns the normalized form in which an address is stored and compared: composed, in lower case,
/// without invisible characters or `mailto:`, and with the domain in Unicode. Browsers submit
/// `münchen.example` as `xn--mnchen-3ya.example`.
#[must_use]
pub fn normalize_email(typed: &str) -> String {
    let visible: String = typed.nfc().filter(|c| !is_invisible(*c)).collect();
    let lower = visible.trim().to_lowercase();
    let address = match lower.strip_prefix("mailto:") {
        Some(link) => link.split_once('?').map_or(link, |(address, _)| address),
        None => &lower,
    };
    match address.rsplit_once('@') {
        Some((user, domain)) => format!("{user}@{}", domain_in_unicode(domain)),
        None => address.to_owned(),
    }
}

fn domain_in_unicode(domain: &str) -> String {
    match idna::domain_to_unicode(domain) {
        (unicode, Ok(())) if !unicode.is_empty() => unicode,
        _ => domain.to_owned(),
    }
}

/// Returns the address with its domain in ASCII: all mail servers accept this form, but only some
/// accept Unicode.
#[must_use]
pub fn email_in_ascii(address: &str) -> String {
    let ascii = |(user, domain): (&str, &str)| Some(format!("{user}@{}", idna::domain_to_ascii(domain).ok()?));
    address.rsplit_once('@').and_then(ascii).unwrap_or_else(|| address.to_owned())
}

/// Returns whether a text is an address like `name@example.org`: the mail library accepts it, and
/// its domain has more than one label.
#[must_use]
pub fn is_email(text: &str) -> bool {
    let Some((name, host)) = text.rsplit_once('@') else { return false };
    EmailAddress::is_valid_local_part(name)
        && is_domain(host)
        && !text.contains(is_odd_in_email)
        && !text.starts_with(['=', '+', '-', '@'])
        && email_in_ascii(text).len() <= LONGEST_ADDRESS
}

/// Returns whether a text is a domain like `example.org`.
#[must_use]
pub fn is_domain(text: &str) -> bool {
    let Ok(ascii) = idna::domain_to_ascii_strict(text) else { return false };
    let last = ascii.rsplit('.').next().unwrap_or_default();
    ascii.contains('.') && EmailAddress::is_valid_domain(&ascii) && last.contains(|c: char| c.is_ascii_alphabetic())
}

/// Returns whether a character is not permitted in an address, even if quoted.
#[must_use]
pub fn is_odd_in_email(c: char) -> bool {
    c.is_whitespace() || is_strange(c) || is_invisible(c) || "<>,;:\"()[]\\".contains(c)
}

#[cfg(test)]
mod tests {
    //! Checks that every accepted address is accepted by the mail library, and that different
    //! spellings of an address are equal after normalization.

    use proptest::prelude::*;

    use super::*;

    #[test]
    fn an_address_that_cannot_be_written_to_is_none() {
        for good in
            ["a@b.co", "jörg@straße.de", "a.b+c@uni-x.ac.uk", "o'brien@uni.example", "ana@xn--mnchen-3ya.example"]
        {
            assert!(is_email(good), "{good}");
        }
        let long = format!("{}@uni.example", "a".repeat(65));
        let wide = format!("a@{}.example", "b".repeat(64));
        for bad in [
            "anna",
            "anna@",
            "anna@localhost",
            "@b.c",
            "a@b",
            "a@.c",
            "a@b.",
            "a@-b.c",
            "a@b-.c",
            "a@b..c",
            "a@1.2.3.4",
            "a@b.c d",
            "a..b@uni.example",
            ".abc@uni.example",
            "abc.@uni.example",
            "a:b@uni.example",
            "a@b@uni.example",
            "mailto:a@uni.example",
            "zw\u{200b}@uni.example",
            "shy\u{ad}@uni.example",
            "a@u\u{2060}ni.example",
            "\"a b\"@uni.example",
            "a@[127.0.0.1]",
            "a\\b@uni.example",
            "a@b_c.example",
            "a\u{a0}@uni.example",
            &long,
            &wide,
        ] {
            assert!(!is_email(bad), "{bad}");
        }
    }

    #[test]
    fn every_spelling_of_an_address_is_one() {
        let one = "jörg@münchen.example";
        for other in [
            "jörg@xn--mnchen-3ya.example",
            "JÖRG@MÜNCHEN.example",
            "jo\u{308}rg@mu\u{308}nchen.example",
            " mailto:jörg@XN--MNCHEN-3YA.example?subject=Hi ",
            "jörg\u{200b}@mün\u{ad}chen.example",
        ] {
            assert_eq!(normalize_email(other), one, "{other:?}");
        }
        assert_eq!(email_in_ascii("ana@münchen.example"), "ana@xn--mnchen-3ya.example");
        assert_eq!(email_in_ascii("no address"), "no address");
    }

    proptest! {
        #[test]
        fn a_normal_address_stays_so(typed in "\\PC{0,30}@?[a-zäöü.A-Z\\-]{0,20}") {
            let normal = normalize_email(&typed);
            prop_assert_eq!(normalize_email(&normal), normal);
        }
    }
}
