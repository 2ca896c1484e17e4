//! Declarations, imports and names of one source file, as parsed by `syn`; code under `#[cfg(test)]` is left out.

use std::collections::{BTreeMap, BTreeSet};

use proc_macro2::{TokenStream, TokenTree};
use syn::punctuated::Punctuated;
use syn::visit::{self, Visit};
use syn::{Attribute, Item, Meta, Token, UseTree, Visibility};

/// The code of one module: of a file, or between the braces of `mod name { … }`.
#[derive(Debug, Default)]
pub struct Body {
    /// Modules that it declares.
    pub modules: Vec<Declaration>,
    /// Items that it defines, by name; an enum with its variants.
    pub items: BTreeMap<String, Vec<String>>,
    /// Macros that it exports to the crate's root.
    pub exported_macros: Vec<String>,
    /// Its `use` declarations, one for each imported name.
    pub imports: Vec<Import>,
    /// Paths that its code names, except in `use` declarations.
    pub paths: Vec<NamedPath>,
    /// Names that its patterns bind: `let gap = …`.
    pub bindings: BTreeSet<String>,
    /// Whether a macro is called in item position: it may define any item.
    pub makes_items: bool,
}

/// A declaration `mod name;` or `mod name { … }`.
#[derive(Debug)]
pub struct Declaration {
    /// The module's name.
    pub name: String,
    /// Its code, if it is between braces.
    pub body: Option<Body>,
    /// File names from `#[path]`, also inside `#[cfg_attr]`.
    pub paths: Vec<String>,
    /// Whether it is compiled only for tests.
    pub test: bool,
}

/// One name of a `use` declaration.
#[derive(Debug)]
pub struct Import {
    /// Path of the imported item; for a glob, of the module before `::*`.
    pub path: Vec<String>,
    /// Name in this module; `None` for a glob.
    pub name: Option<String>,
    /// Visibility of the name.
    pub reach: Reach,
}

/// Visibility of an imported name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reach {
    /// In the module and below it.
    Module,
    /// In a function of the module.
    Function,
    /// Outside the module too: `pub use`, `pub(crate) use`.
    Outside,
}

/// A path in code.
#[derive(Debug)]
pub struct NamedPath {
    /// Its segments.
    pub path: Vec<String>,
    /// Whether it names a macro that is called.
    pub is_macro: bool,
}

impl Body {
    /// Collects the items of a file or of a module between braces.
    pub fn new(items: &[Item]) -> Self {
        let mut body = Self::default();
        for item in items {
            body.item(item);
        }
        body
    }

    fn item(&mut self, item: &Item) {
        let test = is_test(attributes(item));
        if let Item::Mod(module) = item {
            self.modules.push(Declaration {
                name: module.ident.to_string(),
                body: module.content.as_ref().map(|(_, items)| Self::new(items)),
                paths: module.attrs.iter().flat_map(paths_of).collect(),
                test,
            });
            return;
        }
        if test {
            return;
        }
        match item {
            Item::Use(item) => {
                let reach = match item.vis {
                    Visibility::Inherited => Reach::Module,
                    _ => Reach::Outside,
                };
                if item.leading_colon.is_none() {
                    self.import(&item.tree, &mut Vec::new(), reach);
                }
                return;
            }
            Item::Macro(item) => match &item.ident {
                Some(ident) => {
                    let name = ident.to_string();
                    if item.attrs.iter().any(|a| a.path().is_ident("macro_export")) {
                        self.exported_macros.push(name.clone());
                    }
                    self.items.insert(name, Vec::new());
                }
                None => self.makes_items = true,
            },
            _ => {}
        }
        if let Some((name, variants)) = definition(item) {
            self.items.insert(name, variants);
        }
        self.visit_item(item);
    }

    fn import(&mut self, tree: &UseTree, prefix: &mut Vec<String>, reach: Reach) {
        let mut add = |path: Vec<String>, name: Option<String>| {
            self.imports.push(Import { path, name, reach });
        };
        let path_with = |name: &syn::Ident| {
            let mut path = prefix.clone();
            if name != "self" || prefix.is_empty() {
                path.push(name.to_string());
            }
            path
        };
        match tree {
            UseTree::Path(path) => {
                prefix.push(path.ident.to_string());
                self.import(&path.tree, prefix, reach);
                prefix.pop();
            }
            UseTree::Name(name) => {
                let path = path_with(&name.ident);
                let name = path.last().cloned();
                add(path, name);
            }
            UseTree::Rename(rename) => {
                add(path_with(&rename.ident), Some(rename.rename.to_string()));
            }
            UseTree::Glob(_) => add(prefix.clone(), None),
            UseTree::Group(group) => {
                for tree in &group.items {
                    self.import(tree, prefix, reach);
                }
            }
        }
    }

    /// Adds the paths named in the arguments of a macro or an attribute, as far as the tokens show them.
    fn tokens(&mut self, tokens: TokenStream) {
        let tokens: Vec<_> = tokens.into_iter().collect();
        let punct = |index: Option<usize>, mark: char| {
            matches!(index.and_then(|index| tokens.get(index)),
                Some(TokenTree::Punct(punct)) if punct.as_char() == mark)
        };
        let mut next_index = 0;
        while next_index < tokens.len() {
            let begin = next_index;
            next_index += 1;
            match &tokens[begin] {
                TokenTree::Group(group) => self.tokens(group.stream()),
                TokenTree::Ident(ident) => {
                    let mut path = vec![ident.to_string()];
                    while punct(Some(next_index), ':')
                        && punct(Some(next_index + 1), ':')
                        && let Some(TokenTree::Ident(segment)) = tokens.get(next_index + 2)
                    {
                        path.push(segment.to_string());
                        next_index += 3;
                    }
                    let follows = |mark| punct(begin.checked_sub(1), mark);
                    let is_member = follows('.') && !punct(begin.checked_sub(2), '.');
                    let is_macro_variable = follows('$') && path[0] != "crate";
                    let is_label = path.len() == 1
                        && (punct(Some(next_index), ':') && !punct(Some(next_index + 1), ':')
                            || punct(Some(next_index), '=') && !punct(Some(next_index + 1), '='));
                    if !(is_member
                        || is_macro_variable
                        || follows('\'')
                        || follows(':')
                        || is_label)
                    {
                        let is_macro =
                            punct(Some(next_index), '!') && !punct(Some(next_index + 1), '=');
                        self.paths.push(NamedPath { path, is_macro });
                    }
                }
                _ => {}
            }
        }
    }

    /// Adds the paths that serde's attributes give as text: `#[serde(with = "angle")]`.
    fn serde(&mut self, attribute: &Attribute) {
        let pairs = Punctuated::<Meta, Token![,]>::parse_terminated;
        for meta in attribute.parse_args_with(pairs).into_iter().flatten() {
            if let Meta::NameValue(pair) = meta
                && !pair.path.is_ident("rename")
                && let syn::Expr::Lit(literal) = &pair.value
                && let syn::Lit::Str(text) = &literal.lit
                && let Ok(path) = text.parse::<syn::Path>()
            {
                self.visit_path(&path);
            }
        }
    }
}

impl<'ast> Visit<'ast> for Body {
    fn visit_path(&mut self, path: &'ast syn::Path) {
        if path.leading_colon.is_none() {
            self.paths.push(NamedPath {
                path: path
                    .segments
                    .iter()
                    .map(|segment| segment.ident.to_string())
                    .collect(),
                is_macro: false,
            });
        }
        visit::visit_path(self, path);
    }

    fn visit_expr_path(&mut self, expr: &'ast syn::ExprPath) {
        match &expr.qself {
            // `<Type>::function`: the path begins inside the type.
            Some(qself) if qself.position == 0 => self.visit_qself(qself),
            _ => visit::visit_expr_path(self, expr),
        }
    }

    fn visit_type_path(&mut self, ty: &'ast syn::TypePath) {
        match &ty.qself {
            Some(qself) if qself.position == 0 => self.visit_qself(qself),
            _ => visit::visit_type_path(self, ty),
        }
    }

    fn visit_macro(&mut self, mac: &'ast syn::Macro) {
        self.paths.push(NamedPath {
            path: mac
                .path
                .segments
                .iter()
                .map(|segment| segment.ident.to_string())
                .collect(),
            is_macro: true,
        });
        self.tokens(mac.tokens.clone());
    }

    fn visit_attribute(&mut self, attribute: &'ast Attribute) {
        match &attribute.meta {
            Meta::List(list) if list.path.is_ident("serde") => self.serde(attribute),
            Meta::List(list) if !list.path.is_ident("cfg") => self.tokens(list.tokens.clone()),
            _ => {}
        }
    }

    fn visit_visibility(&mut self, _: &'ast Visibility) {}

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        if item.leading_colon.is_none() {
            self.import(&item.tree, &mut Vec::new(), Reach::Function);
        }
    }

    fn visit_pat_ident(&mut self, pattern: &'ast syn::PatIdent) {
        self.bindings.insert(pattern.ident.to_string());
        visit::visit_pat_ident(self, pattern);
    }

    fn visit_item(&mut self, item: &'ast Item) {
        if !is_test(attributes(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_impl_item(&mut self, item: &'ast syn::ImplItem) {
        let attributes: &[Attribute] = match item {
            syn::ImplItem::Const(item) => &item.attrs,
            syn::ImplItem::Fn(item) => &item.attrs,
            syn::ImplItem::Type(item) => &item.attrs,
            syn::ImplItem::Macro(item) => &item.attrs,
            _ => &[],
        };
        if !is_test(attributes) {
            visit::visit_impl_item(self, item);
        }
    }

    fn visit_local(&mut self, local: &'ast syn::Local) {
        if !is_test(&local.attrs) {
            visit::visit_local(self, local);
        }
    }

    fn visit_expr_block(&mut self, block: &'ast syn::ExprBlock) {
        if !is_test(&block.attrs) {
            visit::visit_expr_block(self, block);
        }
    }

    fn visit_field(&mut self, field: &'ast syn::Field) {
        if !is_test(&field.attrs) {
            visit::visit_field(self, field);
        }
    }

    fn visit_arm(&mut self, arm: &'ast syn::Arm) {
        if !is_test(&arm.attrs) {
            visit::visit_arm(self, arm);
        }
    }
}

/// Returns the attributes of an item.
fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::ExternCrate(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::ForeignMod(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Macro(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Static(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Trait(item) => &item.attrs,
        Item::TraitAlias(item) => &item.attrs,
        Item::Type(item) => &item.attrs,
        Item::Union(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}

/// Returns the name that an item defines, with an enum's variants.
fn definition(item: &Item) -> Option<(String, Vec<String>)> {
    let ident = match item {
        Item::Const(item) => &item.ident,
        Item::Enum(item) => {
            let variants = item.variants.iter();
            let variants = variants.map(|variant| variant.ident.to_string());
            return Some((item.ident.to_string(), variants.collect()));
        }
        Item::Fn(item) => &item.sig.ident,
        Item::Static(item) => &item.ident,
        Item::Struct(item) => &item.ident,
        Item::Trait(item) => &item.ident,
        Item::TraitAlias(item) => &item.ident,
        Item::Type(item) => &item.ident,
        Item::Union(item) => &item.ident,
        _ => return None,
    };
    Some((ident.to_string(), Vec::new()))
}

/// Returns whether the attributes mark an item as test code: `#[test]`, `#[cfg(test)]`, `#[cfg(all(test, …))]`.
fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("test")
            || attribute.path().is_ident("cfg")
                && attribute
                    .parse_args::<Meta>()
                    .is_ok_and(|condition| wants_test(&condition))
    })
}

fn wants_test(condition: &Meta) -> bool {
    match condition {
        Meta::Path(path) => path.is_ident("test"),
        Meta::List(list) if list.path.is_ident("all") || list.path.is_ident("any") => {
            let requires_all = list.path.is_ident("all");
            let parts = list.parse_args_with(Punctuated::<Meta, Token![,]>::parse_terminated);
            let mut parts = parts.into_iter().flatten().peekable();
            let has_parts = parts.peek().is_some();
            if requires_all {
                parts.any(|part| wants_test(&part))
            } else {
                has_parts && parts.all(|part| wants_test(&part))
            }
        }
        _ => false,
    }
}

/// Returns the file names of `#[path = "…"]` and `#[cfg_attr(…, path = "…")]`.
fn paths_of(attribute: &Attribute) -> Vec<String> {
    let text = |meta: &Meta| match meta {
        Meta::NameValue(pair) if pair.path.is_ident("path") => match &pair.value {
            syn::Expr::Lit(syn::ExprLit {
                lit: syn::Lit::Str(text),
                ..
            }) => Some(text.value()),
            _ => None,
        },
        _ => None,
    };
    if attribute.path().is_ident("cfg_attr") {
        let metas = Punctuated::<Meta, Token![,]>::parse_terminated;
        let metas = attribute.parse_args_with(metas);
        return metas.iter().flatten().filter_map(text).collect();
    }
    text(&attribute.meta).into_iter().collect()
}
