//! The network address of a client.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};

use axum::extract::{ConnectInfo, FromRequestParts, Request};
use axum::http::request::Parts;
use axum::http::{Extensions, HeaderMap};

use crate::AppState;
use crate::refusals::RequestFacts;

/// The client's network address, reduced by [`subscriber`]; behind a trusted proxy, the address
/// reported by the proxy.
pub struct ClientAddress(pub IpAddr);

impl FromRequestParts<AppState> for ClientAddress {
    type Rejection = std::convert::Infallible;

    async fn from_request_parts(parts: &mut Parts, state: &AppState) -> Result<Self, Self::Rejection> {
        Ok(Self::of(state, &parts.extensions, &parts.headers))
    }
}

impl ClientAddress {
    /// Returns the address for a request with these extensions and headers.
    pub(super) fn of(state: &AppState, extensions: &Extensions, headers: &HeaderMap) -> Self {
        let peer = extensions.get::<ConnectInfo<SocketAddr>>().map(|info| info.0.ip());
        let told = if state.config.behind_tls { last_hop(headers) } else { None };
        Self(subscriber(told.or(peer).unwrap_or(IpAddr::V4(Ipv4Addr::UNSPECIFIED))))
    }
}

/// Returns the last address of the last header line, which the proxy has added; earlier ones come
/// from the client and can be forged. Some proxies add a port.
fn last_hop(headers: &HeaderMap) -> Option<IpAddr> {
    let line = headers.get_all("x-forwarded-for").into_iter().next_back()?.to_str().ok()?;
    let hop = line.rsplit(',').next()?.trim();
    let bare = || hop.strip_prefix('[')?.strip_suffix(']')?.parse().ok();
    let told: IpAddr = hop.parse().ok().or_else(|| Some(hop.parse::<SocketAddr>().ok()?.ip())).or_else(bare)?;
    Some(told.to_canonical())
}

/// Returns the address by which clients are counted: the /64 prefix of an IPv6 address, since a
/// subscriber has at least 2⁶⁴ of them.
#[must_use]
pub fn subscriber(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(address) => IpAddr::V6(Ipv6Addr::from_bits(address.to_bits() & !u128::from(u64::MAX))),
        four @ IpAddr::V4(_) => four,
    }
}

/// Returns method, route, object and client address of a request.
pub fn asked_by(state: &AppState, request: &Request) -> RequestFacts {
    let ClientAddress(from) = ClientAddress::of(state, request.extensions(), request.headers());
    RequestFacts::by(request, from)
}

#[cfg(test)]
mod tests {
    //! A client that can choose its own address evades the rate limits.

    use super::*;

    fn told(lines: &[&str]) -> Option<String> {
        let mut headers = HeaderMap::new();
        for line in lines {
            headers.append("x-forwarded-for", line.parse().unwrap());
        }
        last_hop(&headers).map(|address| address.to_string())
    }

    #[test]
    fn only_the_proxys_own_word_counts() {
        for (lines, expected) in [
            (&["10.0.0.1"][..], Some("10.0.0.1")),
            (&["6.6.6.6, 10.0.0.1"], Some("10.0.0.1")),
            (&["6.6.6.6", "10.0.0.1"], Some("10.0.0.1")),
            (&["10.0.0.1:4711"], Some("10.0.0.1")),
            (&["[2001:db8::1]:4711"], Some("2001:db8::1")),
            (&["[2001:db8::1]"], Some("2001:db8::1")),
            (&["2001:db8::1"], Some("2001:db8::1")),
            (&["::ffff:10.0.0.1"], Some("10.0.0.1")),
            (&["unknown"], None),
            (&["10.0.0.1", ""], None),
            (&[], None),
        ] {
            assert_eq!(told(lines).as_deref(), expected, "{lines:?}");
        }
    }

    #[test]
    fn addresses_of_one_subscriber_are_one() {
        let of = |address: &str| subscriber(address.parse().unwrap()).to_string();
        assert_eq!(of("2001:db8:1:2:3:4:5:6"), of("2001:db8:1:2::1"));
        assert_ne!(of("2001:db8:1:2::1"), of("2001:db8:1:3::1"));
        assert_eq!((of("::ffff:10.0.0.1"), of("10.0.0.2")), ("10.0.0.1".to_owned(), "10.0.0.2".to_owned()));
    }
}
