//! What `wingbeat_config::inside` shows: parts of the reading of documents and of the search.

mod document_airfoil;
mod document_limits;
mod document_outline;
mod document_outline_drawing;
mod document_source;
mod document_tree;
mod schema;
mod sound;
mod tether;
mod tether_converge;
mod trim_alone;
mod trim_alone_balance;
mod trim_alone_guess;
mod trim_search_descent;
mod trim_search_quadratic;
