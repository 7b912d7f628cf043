//! How the code of what ships is written, measured on its syntax. Each limit stands where respected code of its kind stands; it fails
//! when a type takes the name of another, a tuple takes the place of arguments, ids of several kinds share a type, a name is too
//! general, the name of a test is too long, or modules depend on each other in a circle.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use syn::visit::{self, Visit};
use tests::metadata;

use crate::house::sources;

/// A source of what ships, read. Modules that are tests are not in it.
struct Source {
    /// The crate that it is in.
    package: String,
    /// From the crate's `src`.
    path: PathBuf,
    syntax: syn::File,
}

/// Crates that measure others or test them: they do not ship.
const NOT_SHIPPED: [&str; 6] = ["trials", "bench", "xtask", "tests", "inverse-service", "libhd"];

/// Crates of the service: what its things are known by are types of `model::ids`.
const SERVICE: [&str; 15] = [
    "words",
    "model",
    "store",
    "platform",
    "acts",
    "pages",
    "routes-base",
    "routes-people",
    "routes-training",
    "routes-scoring",
    "routes-surveys",
    "routes-api",
    "worker",
    "demo",
    "web-admin",
];

/// The median name of a free function has so many characters at least. Respected code of this kind has 12 to 20: raise it when names
/// have grown.
const LEAST_MEDIAN: usize = 12;

/// The most characters in the name of a test: it states a law as subject, verb and object, and fits a line of a report with its module.
const MOST_IN_TEST_NAME: usize = 60;

/// Whether an item is only there for tests.
fn is_for_tests(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let list = attribute.meta.require_list().ok();
        attribute.path().is_ident("cfg") && list.is_some_and(|list| list.tokens.to_string() == "test")
    })
}

/// Every source of the crates that ship.
fn shipped_sources() -> Vec<Source> {
    let mut sources = Vec::new();
    for package in metadata().workspace_packages() {
        if !NOT_SHIPPED.contains(&package.name.as_str()) {
            let folder = package.manifest_path.parent().expect("a folder").join("src").into_std_path_buf();
            let top = if folder.join("lib.rs").exists() { "lib.rs" } else { "main.rs" };
            read_module(&package.name, &folder, &folder.join(top), &folder, &mut sources);
        }
    }
    assert!(sources.len() > 500, "only {} sources were found", sources.len());
    sources
}

/// Reads a file and the modules that it names, but for those of tests. `below` is where its modules lie.
fn read_module(package: &str, folder: &Path, file: &Path, below: &Path, sources: &mut Vec<Source>) {
    let text = std::fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let mut syntax = syn::parse_file(&text).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    syntax.items.retain(|item| !matches!(item, syn::Item::Mod(module) if is_for_tests(&module.attrs)));
    for item in &syntax.items {
        let syn::Item::Mod(module) = item else { continue };
        if module.content.is_none() {
            let inner = below.join(module.ident.to_string());
            let own = inner.with_extension("rs");
            let next = if own.exists() { own } else { inner.join("mod.rs") };
            read_module(package, folder, &next, &inner, sources);
        }
    }
    let path = file.strip_prefix(folder).expect("below its crate").to_owned();
    sources.push(Source { package: package.to_owned(), path, syntax });
}

/// What is counted in the sources.
#[derive(Default)]
struct Count {
    place: String,
    /// Where each name of a type stands.
    types: BTreeMap<String, Vec<String>>,
    /// Names of functions outside of types.
    free_functions: Vec<String>,
    /// Functions, and those of them that take a tuple as an argument.
    functions: usize,
    tuples: Vec<String>,
    in_trait_impl: bool,
    /// Functions of the service, and those of them that take two or more ids of no kind.
    in_service: bool,
    of_service: usize,
    bare_ids: Vec<String>,
}

impl Count {
    fn name_type(&mut self, name: &syn::Ident) {
        self.types.entry(name.to_string()).or_default().push(self.place.clone());
    }

    fn take_signature(&mut self, signature: &syn::Signature) {
        self.functions += 1;
        self.of_service += usize::from(self.in_service);
        // A trait of somebody else's says what its functions take.
        if self.in_trait_impl {
            return;
        }
        let arguments = |is: fn(&syn::Type) -> bool| {
            let typed = |input: &&syn::FnArg| matches!(input, syn::FnArg::Typed(argument) if is(&argument.ty));
            signature.inputs.iter().filter(typed).count()
        };
        if arguments(is_tuple) > 0 {
            self.tuples.push(format!("{}: {}", self.place, signature.ident));
        }
        if self.in_service && arguments(is_bare_id) > 1 {
            self.bare_ids.push(format!("{}: {}", self.place, signature.ident));
        }
    }
}

/// `Uuid`, one that is lent, several of them, or one that may be absent.
fn is_bare_id(argument: &syn::Type) -> bool {
    match argument {
        syn::Type::Reference(reference) => is_bare_id(&reference.elem),
        syn::Type::Slice(several) => is_bare_id(&several.elem),
        syn::Type::Paren(inner) => is_bare_id(&inner.elem),
        syn::Type::Path(path) => path.path.segments.last().is_some_and(|last| match &last.arguments {
            syn::PathArguments::AngleBracketed(within) if last.ident == "Option" => {
                within.args.iter().any(|of| matches!(of, syn::GenericArgument::Type(of) if is_bare_id(of)))
            }
            _ => last.ident == "Uuid",
        }),
        _ => false,
    }
}

fn is_tuple(argument: &syn::Type) -> bool {
    match argument {
        syn::Type::Tuple(tuple) => tuple.elems.len() > 1,
        syn::Type::Reference(reference) => is_tuple(&reference.elem),
        syn::Type::Paren(inner) => is_tuple(&inner.elem),
        _ => false,
    }
}

impl<'ast> Visit<'ast> for Count {
    fn visit_item_mod(&mut self, module: &'ast syn::ItemMod) {
        if !is_for_tests(&module.attrs) {
            visit::visit_item_mod(self, module);
        }
    }

    fn visit_item_struct(&mut self, item: &'ast syn::ItemStruct) {
        self.name_type(&item.ident);
        visit::visit_item_struct(self, item);
    }

    fn visit_item_enum(&mut self, item: &'ast syn::ItemEnum) {
        self.name_type(&item.ident);
        visit::visit_item_enum(self, item);
    }

    fn visit_item_trait(&mut self, item: &'ast syn::ItemTrait) {
        self.name_type(&item.ident);
        visit::visit_item_trait(self, item);
    }

    fn visit_item_type(&mut self, item: &'ast syn::ItemType) {
        self.name_type(&item.ident);
        visit::visit_item_type(self, item);
    }

    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        if is_for_tests(&item.attrs) {
            return;
        }
        self.free_functions.push(item.sig.ident.to_string());
        self.take_signature(&item.sig);
        visit::visit_item_fn(self, item);
    }

    fn visit_item_impl(&mut self, item: &'ast syn::ItemImpl) {
        let outer = std::mem::replace(&mut self.in_trait_impl, item.trait_.is_some());
        visit::visit_item_impl(self, item);
        self.in_trait_impl = outer;
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        self.take_signature(&item.sig);
        visit::visit_impl_item_fn(self, item);
    }

    fn visit_trait_item_fn(&mut self, item: &'ast syn::TraitItemFn) {
        self.take_signature(&item.sig);
        visit::visit_trait_item_fn(self, item);
    }
}

fn count_shipped() -> Count {
    let mut count = Count::default();
    for source in shipped_sources() {
        count.in_service = SERVICE.contains(&source.package.as_str());
        count.place = format!("{}/{}", source.package, source.path.display());
        count.visit_file(&source.syntax);
    }
    count
}

#[test]
fn a_type_has_a_name_of_its_own() {
    let count = count_shipped();
    let shared: BTreeMap<_, _> = count.types.iter().filter(|(_, places)| places.len() > 1).collect();
    let all: usize = count.types.values().map(Vec::len).sum();
    let not_unique: usize = shared.values().map(|places| places.len()).sum();
    let share = 100.0 * not_unique as f64 / all as f64;
    let mut most: Vec<_> = shared.iter().map(|(name, places)| (places.len(), *name, *places)).collect();
    most.sort_by_key(|(times, _, _)| std::cmp::Reverse(*times));
    println!("{not_unique} of {all} types share their name: {share:.1} %");
    assert!(share <= 12.0, "{share:.1} % of the types share their name, at most 12 % may: {most:#?}");
}

#[test]
fn no_tuple_stands_in_for_arguments() {
    let count = count_shipped();
    println!("{} of {} functions take a tuple", count.tuples.len(), count.functions);
    assert!(count.tuples.is_empty(), "{} functions take a tuple: {:#?}", count.tuples.len(), count.tuples);
}

#[test]
fn no_function_takes_two_ids_that_could_be_swapped() {
    let count = count_shipped();
    println!("{} of {} functions of the service take two bare ids", count.bare_ids.len(), count.of_service);
    assert!(count.of_service > 1000, "only {} functions of the service were found", count.of_service);
    assert!(count.bare_ids.is_empty(), "{} functions take two bare ids: {:#?}", count.bare_ids.len(), count.bare_ids);
}

#[test]
fn functions_have_names_that_can_be_searched_for() {
    let mut count = count_shipped();
    count.free_functions.sort_by_key(String::len);
    let median = count.free_functions[count.free_functions.len() / 2].len();
    println!("the median name of {} free functions has {median} characters", count.free_functions.len());
    let mut named: BTreeMap<&str, usize> = BTreeMap::new();
    count.free_functions.iter().for_each(|name| *named.entry(name).or_default() += 1);
    let mut most: Vec<_> = named.into_iter().collect();
    most.sort_by_key(|(_, times)| std::cmp::Reverse(*times));
    most.truncate(60);
    assert!(
        median >= LEAST_MEDIAN,
        "the median name has {median} characters, at least {LEAST_MEDIAN} are wanted; the most used: {most:?}"
    );
}

/// The names of the tests in a source. It is read as text, because syntax shows none of those in a macro.
fn test_names(source: &str) -> Vec<&str> {
    let (mut names, mut is_test) = (Vec::new(), false);
    for line in source.lines().map(str::trim_start) {
        is_test |= line.starts_with("#[test]") || line.starts_with("#[tokio::test");
        let function = line.strip_prefix("async ").unwrap_or(line).strip_prefix("fn ");
        if let Some(name) = function.and_then(|rest| rest.split('(').next()) {
            names.extend(is_test.then_some(name));
            is_test = false;
        }
    }
    names
}

#[test]
fn a_test_has_a_name_of_at_most_60_characters() {
    let source =
        "#[tokio::test(flavor = \"x\")]\n#[ignore]\nasync fn a() {}\nfn b() {}\n    #[test]\n    fn c(d in 0..1) {}";
    assert_eq!(test_names(source), ["a", "c"]);
    let sources = sources();
    let names = sources.iter().flat_map(|(path, text)| test_names(text).into_iter().map(move |name| (path, name)));
    let (long, short): (Vec<_>, Vec<_>) = names.partition(|(_, name)| name.len() > MOST_IN_TEST_NAME);
    assert!(short.len() > 1000, "only {} tests were found", short.len());
    assert!(long.is_empty(), "at most {MOST_IN_TEST_NAME} characters name a test, subject, verb, object: {long:#?}");
}

/// Modules at the top level of a crate that a source of another one names.
struct Uses<'a> {
    tops: &'a BTreeSet<String>,
    /// How many `super` lead out of the module at the top.
    depth: usize,
    found: BTreeSet<String>,
}

impl Uses<'_> {
    /// A path as it is written, from its first segment on.
    fn take(&mut self, segments: &[String]) {
        let out = segments.iter().take_while(|segment| *segment == "super").count();
        let top = match segments.first().map(String::as_str) {
            Some("crate") => segments.get(1),
            Some("super") if out == self.depth => segments.get(out),
            _ => None,
        };
        // What the program's root names is where it is.
        let top = top.map(|top| if top == "AppState" { "startup".to_owned() } else { top.clone() });
        self.found.extend(top.filter(|top| self.tops.contains(top)));
    }

    fn take_tree(&mut self, before: &[String], tree: &syn::UseTree) {
        let with = |name: &syn::Ident| [before, &[name.to_string()]].concat();
        match tree {
            syn::UseTree::Path(path) => self.take_tree(&with(&path.ident), &path.tree),
            syn::UseTree::Name(name) => self.take(&with(&name.ident)),
            syn::UseTree::Rename(name) => self.take(&with(&name.ident)),
            syn::UseTree::Glob(_) => self.take(before),
            syn::UseTree::Group(group) => group.items.iter().for_each(|tree| self.take_tree(before, tree)),
        }
    }
}

impl<'ast> Visit<'ast> for Uses<'_> {
    fn visit_item_mod(&mut self, module: &'ast syn::ItemMod) {
        if !is_for_tests(&module.attrs) && module.content.is_none() {
            visit::visit_item_mod(self, module);
        }
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        self.take_tree(&[], &item.tree);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let segments: Vec<String> = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        self.take(&segments);
        visit::visit_path(self, path);
    }
}

/// The module at the top level of its crate that a source belongs to; none for the crate's root.
fn top_of(path: &Path) -> Option<String> {
    let first = path.components().next()?.as_os_str().to_string_lossy().into_owned();
    let name = first.strip_suffix(".rs").unwrap_or(&first);
    (!["lib", "main"].contains(&name)).then(|| name.to_owned())
}

/// How many `super` lead from a source to its crate's root.
fn depth_of(path: &Path) -> usize {
    let parts = path.components().count();
    if path.ends_with("mod.rs") { parts - 1 } else { parts }
}

/// Who uses whom among the modules at the top of each crate.
fn top_level_uses() -> BTreeMap<String, BTreeMap<String, BTreeSet<String>>> {
    let sources = shipped_sources();
    let mut tops: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for source in &sources {
        tops.entry(source.package.clone()).or_default().extend(top_of(&source.path));
    }
    let mut uses: BTreeMap<String, BTreeMap<String, BTreeSet<String>>> = BTreeMap::new();
    for source in &sources {
        let Some(top) = top_of(&source.path) else { continue };
        let mut seen = Uses { tops: &tops[&source.package], depth: depth_of(&source.path), found: BTreeSet::new() };
        seen.visit_file(&source.syntax);
        seen.found.remove(&top);
        uses.entry(source.package.clone()).or_default().entry(top).or_default().extend(seen.found);
    }
    uses
}

/// The modules that a module reaches, itself only where it is in a circle.
fn reached<'a>(from: &'a str, uses: &'a BTreeMap<String, BTreeSet<String>>) -> BTreeSet<&'a str> {
    let (mut seen, mut open) = (BTreeSet::new(), vec![from]);
    while let Some(module) = open.pop() {
        for next in uses.get(module).into_iter().flatten() {
            if seen.insert(next.as_str()) {
                open.push(next);
            }
        }
    }
    seen
}

#[test]
fn no_modules_lean_on_each_other_in_a_circle() {
    let mut circles = Vec::new();
    for (package, uses) in top_level_uses() {
        let within: BTreeSet<_> =
            uses.keys().filter(|module| reached(module, &uses).contains(module.as_str())).collect();
        if !within.is_empty() {
            let edges: Vec<_> = within
                .iter()
                .map(|module| {
                    let to: Vec<_> = uses[*module].iter().filter(|to| within.contains(to)).cloned().collect();
                    format!("{module} -> {}", to.join(", "))
                })
                .collect();
            circles.push(format!("{package}: {edges:#?}"));
        }
    }
    assert!(circles.is_empty(), "modules lean on each other in a circle: {}", circles.join("\n"));
}
