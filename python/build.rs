//! Lets the library be linked on macOS, where the interpreter that loads it provides the functions of Python.

fn main() {
    pyo3_build_config::add_extension_module_link_args();
}
