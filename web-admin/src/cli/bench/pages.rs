//! Finds the pages of the service by following links, counted by route and by the visitor's role.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use axum::http::StatusCode;

use super::visitor::BenchVisitor;

/// Maximum number of addresses that a visitor requests on one route.
const EACH: usize = 10;

/// A page as seen by one role.
pub(super) struct Page {
    /// The role.
    pub role: &'static str,
    /// The route.
    pub route: String,
    /// Requests for the page: the visitor's index, and the address.
    pub asked: Vec<(usize, String)>,
}

/// The pages found by the visitors.
pub(super) struct Tour {
    /// By route, then by role.
    pub pages: Vec<Page>,
    /// Routes of pages that no visitor reached.
    pub unseen: Vec<String>,
}

impl Tour {
    /// Follows every link from each visitor's starting addresses, except links that begin with a
    /// prefix in `aside`. `routes` lists every route of the service; the routes of the API, of
    /// assets and recordings, and those in `aside` are not counted.
    pub(super) async fn take(
        visitors: &[BenchVisitor],
        mut routes: Vec<String>,
        aside: &[&str],
    ) -> anyhow::Result<Self> {
        let files = ["/api/", "/assets/", "/recordings/"];
        routes.retain(|route| !files.iter().chain(aside).any(|other| route.starts_with(other)));
        let mut found: BTreeMap<(String, &'static str), Vec<(usize, String)>> = BTreeMap::new();
        for (place, visitor) in visitors.iter().enumerate() {
            for (route, path) in walk_pages(visitor, &routes, aside).await? {
                found.entry((route, visitor.role)).or_default().push((place, path));
            }
        }
        let seen: BTreeSet<&str> = found.keys().map(|(route, _)| route.as_str()).collect();
        let mut unseen = Vec::new();
        for route in routes.iter().filter(|route| !seen.contains(route.as_str())) {
            if is_html_page(&visitors[0], route).await? {
                unseen.push(route.clone());
            }
        }
        let pages = found.into_iter().map(|((route, role), asked)| Page { role, route, asked }).collect();
        Ok(Self { pages, unseen })
    }
}

/// Returns the addresses that a visitor reached and could open, each with its route, at most
/// [`EACH`] per route.
async fn walk_pages(
    visitor: &BenchVisitor,
    routes: &[String],
    aside: &[&str],
) -> anyhow::Result<Vec<(String, String)>> {
    let mut waiting: VecDeque<String> = visitor.begins.iter().cloned().collect();
    let mut known: BTreeSet<String> = waiting.iter().cloned().collect();
    let mut asked: BTreeMap<&str, usize> = BTreeMap::new();
    let mut shown = Vec::new();
    while let Some(path) = waiting.pop_front() {
        let Some(route) = route_of(&path, routes) else { continue };
        let times = asked.entry(route).or_default();
        *times += 1;
        if *times > EACH {
            continue;
        }
        let answer = visitor.ask(&path, "identity").await?;
        if answer.status == StatusCode::OK {
            shown.push((route.to_owned(), path));
            let found = links_of_page(&String::from_utf8_lossy(&answer.body));
            let fresh = found
                .into_iter()
                .filter(|link| !aside.iter().any(|other| link.starts_with(other)) && known.insert(link.clone()));
            waiting.extend(fresh);
        }
    }
    Ok(shown)
}

/// Returns the links of a page to addresses within the service, without fragments.
fn links_of_page(page: &str) -> Vec<String> {
    let hrefs = page.split("href=\"").skip(1).filter_map(|rest| rest.split('"').next());
    let own = hrefs.filter(|href| href.starts_with('/') && !href.starts_with("//"));
    own.map(|href| href.split('#').next().unwrap_or_default().replace("&amp;", "&").replace("&#38;", "&")).collect()
}

/// Returns the route that serves an address: the one with the fewest parameters among those that
/// match.
fn route_of<'a>(path: &str, routes: &'a [String]) -> Option<&'a str> {
    let path: Vec<&str> = path.split('?').next().unwrap_or_default().split('/').collect();
    let fits = |route: &&String| {
        let parts: Vec<&str> = route.split('/').collect();
        parts.len() == path.len() && parts.iter().zip(&path).all(|(part, own)| part.starts_with('{') || part == own)
    };
    routes.iter().filter(fits).min_by_key(|route| route.matches('{').count()).map(String::as_str)
}

/// Whether a route answers GET; other routes only accept submissions.
async fn is_html_page(visitor: &BenchVisitor, route: &str) -> anyhow::Result<bool> {
    let answer = visitor.ask(&route.replace(['{', '}'], ""), "identity").await?;
    Ok(answer.status != StatusCode::METHOD_NOT_ALLOWED)
}

#[cfg(test)]
mod tests {
    //! Fails when a link is missed or an address is counted under another page.

    use super::*;

    #[test]
    fn links_lead_within_the_service() {
        let page = r##"<a href="/a?x=1&amp;y=2#top"> <a href="https://elsewhere/"> <a href="//other"> <a href="#here"> <a href="/b">"##;
        assert_eq!(links_of_page(page), ["/a?x=1&y=2", "/b"]);
    }

    #[test]
    fn an_address_belongs_to_the_route_that_answers_it() {
        let routes = ["/people/{id}", "/people/roster", "/people"].map(str::to_owned);
        assert_eq!(route_of("/people?q=x", &routes), Some("/people"));
        assert_eq!(route_of("/people/roster", &routes), Some("/people/roster"));
        assert_eq!(route_of("/people/5", &routes), Some("/people/{id}"));
        assert_eq!(route_of("/people/5/link", &routes), None);
    }
}
