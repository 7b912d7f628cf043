//! The file as other programs expect it: profile, topics, schemas, rates, order and times. It would fail where a viewer
//! or a script that keeps to the contract no longer finds what it looks for.
