//! Data flow one way: no module depends on itself, directly or through others.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// The modules that each module uses.
type Uses = BTreeMap<String, BTreeSet<String>>;

/// The sources of a crate by module, without its root and its tests.
fn sources(folder: &Path, prefix: &str, found: &mut BTreeMap<String, String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap();
        if ["lib", "tests", "oracle"].contains(&name) {
            continue;
        }
        if path.is_dir() {
            sources(&path, &format!("{prefix}{name}::"), found);
        } else {
            found.insert(format!("{prefix}{name}"), fs::read_to_string(&path).unwrap());
        }
    }
}

/// The module of a path such as `shapes::points::Points`: the longest part of it that is one.
fn module_of<'a>(path: &'a str, known: &BTreeMap<String, String>) -> Option<&'a str> {
    let ends = path.match_indices("::").map(|(end, _)| end).chain([path.len()]);
    ends.map(|end| &path[..end]).filter(|part| known.contains_key(*part)).last()
}

fn uses(folder: &Path) -> Uses {
    let mut known = BTreeMap::new();
    sources(folder, "", &mut known);
    let used_by = |(name, source): (&String, &String)| {
        let program = source.split("#[cfg(test)]\nmod tests").next().unwrap();
        let code = program.lines().filter(|line| !line.trim_start().starts_with("//"));
        let code: Vec<&str> = code.collect();
        let by_super = code.iter().any(|line| line.contains("super::"));
        assert!(!by_super, "{name} names a module by `super`");
        let used = code.iter().flat_map(|line| line.split("crate::").skip(1)).filter_map(|rest| {
            let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_' && c != ':');
            module_of(&rest[..end.unwrap_or(rest.len())], &known)
        });
        let others = used.filter(|used| used != name).map(str::to_owned).collect();
        (name.clone(), others)
    };
    known.iter().map(used_by).collect()
}

/// The same for the folders at the top.
fn folders(uses: &Uses) -> Uses {
    let top = |name: &String| name.split("::").next().unwrap().to_owned();
    let mut folders = Uses::new();
    for (name, used) in uses {
        let others = used.iter().map(top).filter(|other| *other != top(name));
        folders.entry(top(name)).or_default().extend(others);
    }
    folders
}

/// The modules that are left when those that use nothing else are taken away again and again.
fn in_circles(mut uses: Uses) -> Uses {
    loop {
        let left: BTreeSet<String> = uses.keys().cloned().collect();
        uses.retain(|_, used| used.iter().any(|name| left.contains(name)));
        if uses.len() == left.len() {
            return uses;
        }
    }
}

#[test]
fn no_module_uses_one_that_uses_it() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for folder in ["src", "python/src"] {
        let uses = uses(&root.join(folder));
        assert!(uses.values().any(|used| !used.is_empty()), "{folder}");
        assert_eq!(in_circles(folders(&uses)), Uses::new(), "{folder}");
        assert_eq!(in_circles(uses), Uses::new(), "{folder}");
    }
}
