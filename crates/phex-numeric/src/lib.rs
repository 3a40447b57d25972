//! phex-numeric
