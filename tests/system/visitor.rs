//! Somebody with a browser but without JavaScript, who has signed in through the form.

use ureq::Agent;

/// The cookie is carried by hand: the session gets a new id at sign-in, and an old one must not work.
pub struct Visitor {
    agent: Agent,
    url: String,
    cookie: String,
}

impl Visitor {
    /// Signs in.
    pub fn signed_in(url: &str, email: &str, password: &str) -> Self {
        let agent: Agent = Agent::config_builder().max_redirects(0).build().into();
        let mut login = agent.get(format!("{url}/login")).call().expect("the sign-in page");
        let form = login.body_mut().read_to_string().expect("a body");
        let signed_in = agent
            .post(format!("{url}/login"))
            .header("Cookie", cookie(&login))
            .send_form([("email", email), ("password", password), ("csrf", csrf(&form))])
            .expect("signed in");
        assert_ne!(cookie(&signed_in), cookie(&login), "the session keeps its id");
        Self { agent, url: url.to_owned(), cookie: cookie(&signed_in) }
    }

    /// A page.
    pub fn page(&self, path: &str) -> String {
        let asked = self.agent.get(format!("{}{path}", self.url)).header("Cookie", &self.cookie).call();
        let answer = asked.expect("the page");
        assert_eq!(answer.status(), 200, "{path}");
        answer.into_body().read_to_string().expect("a body")
    }

    /// Presses the button of a form without fields on the page `from`; the page it leads to.
    pub fn press(&self, from: &str, path: &str) -> String {
        self.send(from, path, &[])
    }

    /// Sends a form of the page `from`; the page it leads to.
    pub fn send(&self, from: &str, path: &str, fields: &[(&str, &str)]) -> String {
        let form = self.page(from);
        let pressed = self.agent.post(format!("{}{path}", self.url)).header("Cookie", &self.cookie);
        let fields = [&[("csrf", csrf(&form))], fields].concat();
        let answer = pressed.send_form(fields).expect("the next page");
        answer.into_body().read_to_string().expect("a body")
    }
}

/// The password that the command line has given somebody: for their first sign-in, at which they choose their own.
pub const INITIAL: &str = "herons that wade at dawn";

/// Chooses somebody's own password at their first sign-in.
pub fn choose_password(url: &str, email: &str, own: &str) {
    let agent: Agent = Agent::config_builder().max_redirects(0).build().into();
    let mut login = agent.get(format!("{url}/login")).call().expect("the sign-in page");
    let form = login.body_mut().read_to_string().expect("a body");
    let post = |path: &str| agent.post(format!("{url}{path}")).header("Cookie", cookie(&login));
    let led = post("/login").send_form([("email", email), ("password", INITIAL), ("csrf", csrf(&form))]).expect("led");
    let to = led.headers().get("location").and_then(|value| value.to_str().ok()).expect("a place to go");
    assert!(to.starts_with("/join/"), "{email} is led to {to}");
    let page = agent.get(format!("{url}{to}")).header("Cookie", cookie(&login)).call().expect("the page");
    let page = page.into_body().read_to_string().expect("a body");
    let chosen = post(to).send_form([("password", own), ("again", own), ("csrf", csrf(&page))]).expect("chosen");
    assert_eq!(chosen.status(), 303, "{email} has a password of their own");
}

/// The token in the first form of a page.
fn csrf(page: &str) -> &str {
    page.split("name=\"csrf\" value=\"").nth(1).and_then(|rest| rest.split('"').next()).expect("a form token")
}

/// The cookie that an answer sets.
fn cookie<B>(answer: &http::Response<B>) -> String {
    let set = answer.headers().get("set-cookie").and_then(|value| value.to_str().ok()).expect("a cookie");
    set.split(';').next().unwrap_or_default().to_owned()
}
