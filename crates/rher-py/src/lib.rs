//! Python bindings of `rher`: not written yet, see CHANGELOG.md for when they are.
