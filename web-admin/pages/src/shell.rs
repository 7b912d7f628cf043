//! The frame of every page: head, navigation and signed-in user.

use model::{CurrentPerson, Role};

use crate::{assets, flash_message, school_time};

/// Place of a page in the navigation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NavPlace {
    /// `/`
    Home,
    /// `/cohorts`
    Cohorts,
    /// `/review`
    Review,
    /// `/curricula`
    Curricula,
    /// `/surveys`
    Surveys,
    /// `/assignments`
    Assignments,
    /// `/people`
    People,
    /// `/admin`
    Administration,
    /// `/account`
    Account,
    /// `/account/second-factor`, for users who must set up a second factor first: without
    /// navigation.
    Enrolment,
    /// Not part of the navigation.
    Elsewhere,
}

/// An entry of the navigation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NavItem {
    /// Address.
    pub href: &'static str,
    /// Word.
    pub label: &'static str,
    /// Whether the current page belongs here.
    pub current: bool,
    /// Number of unread news items.
    pub news: u32,
}

/// The signed-in user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShellVisitor {
    /// Name.
    pub name: String,
    /// Role.
    pub role: Role,
}

/// The frame around a page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shell {
    /// The signed-in user.
    pub visitor: ShellVisitor,
    /// CSRF token for the sign-out form.
    pub csrf: String,
    /// Place of the page in the navigation.
    pub place: NavPlace,
    /// Number of unread news items.
    pub news: u32,
    /// Address of the school's logo, if it has one.
    pub logo: Option<String>,
}

impl Shell {
    /// Creates the frame for a user.
    #[must_use]
    pub fn new(person: &CurrentPerson, csrf: &str, place: NavPlace) -> Self {
        let visitor = ShellVisitor { name: person.display_name.clone(), role: person.role };
        let logo = person.logo.as_ref().map(|version| format!("/school/logo?v={version}"));
        Self { visitor, csrf: csrf.to_owned(), place, news: person.news, logo }
    }

    /// Returns the address of the style sheet.
    #[must_use]
    pub fn style(&self) -> &'static str {
        assets::style_sheet()
    }

    /// Returns the text of the flash message, if there is one.
    #[must_use]
    pub fn deed(&self) -> Option<&'static str> {
        flash_message::say_done()
    }

    /// Returns the address of the script that sorts tables.
    #[must_use]
    pub fn tables(&self) -> &'static str {
        assets::table_script()
    }

    /// Returns the name of the time zone in which times are shown.
    #[must_use]
    pub fn zone(&self) -> String {
        school_time::zone_name()
    }

    /// Returns the navigation entries that this user may open.
    #[must_use]
    pub fn nav(&self) -> Vec<NavItem> {
        let all = [
            (NavPlace::Home, "/", tr!("Home")),
            (NavPlace::Cohorts, "/cohorts", tr!("Cohorts")),
            (NavPlace::Review, "/review", tr!("Review")),
            (NavPlace::Curricula, "/curricula", tr!("Curricula")),
            (NavPlace::Surveys, "/surveys", tr!("Surveys")),
            (NavPlace::Assignments, "/assignments", tr!("Assignments")),
            (NavPlace::People, "/people", tr!("People")),
            (NavPlace::Administration, "/admin", tr!("Administration")),
        ];
        let allowed = |place| match place {
            _ if self.place == NavPlace::Enrolment => false,
            NavPlace::Cohorts | NavPlace::Review => self.visitor.role != Role::Trainee,
            NavPlace::People | NavPlace::Administration => self.visitor.role == Role::Administrator,
            _ => true,
        };
        all.into_iter()
            .filter(|(place, ..)| allowed(*place))
            .map(|(place, href, label)| NavItem {
                href,
                label,
                current: place == self.place,
                news: if place == NavPlace::Home { self.news } else { 0 },
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    //! Users must not be led to pages that refuse them.

    use super::*;

    #[test]
    fn each_role_sees_its_own_pages() {
        let hrefs = |role| -> Vec<&str> {
            let visitor = ShellVisitor { name: "x".to_owned(), role };
            let shell = Shell { visitor, csrf: String::new(), place: NavPlace::Home, news: 2, logo: None };
            shell.nav().iter().map(|n| n.href).collect()
        };
        assert_eq!(hrefs(Role::Trainee), ["/", "/curricula", "/surveys", "/assignments"]);
        let instructor = ["/", "/cohorts", "/review", "/curricula", "/surveys", "/assignments"];
        assert_eq!(hrefs(Role::Instructor), instructor);
        let visitor = ShellVisitor { name: "x".to_owned(), role: Role::Trainee };
        let shell = Shell { visitor, csrf: String::new(), place: NavPlace::Curricula, news: 2, logo: None };
        let news: Vec<u32> = shell.nav().iter().map(|item| item.news).collect();
        assert_eq!(news, [2, 0, 0, 0], "what is new stands on the home page");
        assert_eq!(hrefs(Role::Administrator), [&instructor[..], &["/people", "/admin"]].concat());
    }
}
