//! A part of a long list of people: looked for by name, a page at a time.

use model::count_u32;
use model::search_key::{make_search_text, split_search_words};

/// People on one page.
const PER_PAGE: usize = 50;

/// A stretch of a long list.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PageNumbers {
    /// This stretch, from 1.
    pub page: u32,
    /// How many stretches there are.
    pub last: u32,
    /// How many entries there are in all.
    pub entries: u32,
}

/// What is looked for, and which page is wanted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ListQuery {
    /// Words of names.
    pub q: String,
    /// The page, from 1.
    pub page: Option<u32>,
    /// What else the address says: names and values.
    pub kept: Vec<(&'static str, String)>,
}

/// Which part of a list a page shows.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ListPart {
    /// What was looked for.
    pub query: ListQuery,
    /// The page, and how many were found.
    pub pages: PageNumbers,
    /// How many there are in all.
    pub all: usize,
}

impl ListPart {
    /// The people whose names have all of the words, as many as a page shows.
    #[must_use]
    pub fn of<T>(query: ListQuery, people: Vec<T>, name: impl Fn(&T) -> &str) -> (Vec<T>, Self) {
        let (all, words) = (people.len(), split_search_words(&query.q));
        let has_words = |one: &T| {
            let folded = make_search_text(name(one), "", None);
            words.iter().all(|word| folded.contains(word.as_str()))
        };
        let found: Vec<T> = people.into_iter().filter(|one| words.is_empty() || has_words(one)).collect();
        let last = found.len().div_ceil(PER_PAGE).max(1);
        let page = (query.page.unwrap_or(1) as usize).clamp(1, last);
        let pages = PageNumbers { page: count_u32(page), last: count_u32(last), entries: count_u32(found.len()) };
        let part = found.into_iter().skip((page - 1) * PER_PAGE).take(PER_PAGE).collect();
        (part, Self { query, pages, all })
    }

    /// There are more than one page shows, or something is looked for.
    #[must_use]
    pub fn is_long(&self) -> bool {
        self.all > PER_PAGE || !self.query.q.is_empty()
    }

    /// Which page this is, in words.
    #[must_use]
    pub fn say_page(&self) -> String {
        tr!("Page {page} of {last}", page = self.pages.page, last = self.pages.last)
    }

    /// How many are found, in words.
    #[must_use]
    pub fn say_found(&self) -> String {
        tr!("{found} of {all}", found = self.pages.entries, all = self.all)
    }
}

#[cfg(test)]
mod tests {
    //! Fails when somebody of a long list cannot be reached.

    use super::*;

    fn part(q: &str, page: Option<u32>) -> (Vec<String>, ListPart) {
        let people = (0..120).map(|n| format!("Jörg {n}")).collect();
        let query = ListQuery { q: q.to_owned(), page, kept: Vec::new() };
        ListPart::of(query, people, String::as_str)
    }

    #[test]
    fn everybody_is_on_a_page_and_is_found_by_name() {
        let pages: Vec<usize> = (1..=3).map(|page| part("", Some(page)).0.len()).collect();
        assert_eq!(pages, [50, 50, 20]);
        assert_eq!(part("", Some(99)).0, part("", Some(3)).0, "a page beyond the last is the last");
        let (found, part) = part("joerg 11", None);
        assert_eq!(found.len(), 11, "{found:?}");
        assert!(part.is_long() && part.say_found() == "11 of 120");
    }
}
