//! What stands in the place of schemars where no schemas are made.
//!
//! The documents' schemas are made by tests and by `cargo xtask reference`; the program prints those that were made. Without the
//! feature `schema` a crate with documents names this crate `schemars`, so that its types need not say twice what they derive.

use proc_macro::TokenStream;

/// The derive of schemars by name and attribute, which writes nothing.
#[proc_macro_derive(JsonSchema, attributes(schemars))]
pub fn no_schema(_: TokenStream) -> TokenStream {
    TokenStream::new()
}
