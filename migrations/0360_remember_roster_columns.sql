-- Which column of a roster tells what, as somebody of the school has said it, by the headings of the file.
CREATE TABLE roster_mappings (
    school_id BLOB NOT NULL REFERENCES schools (id),
    headings_sha256 BLOB NOT NULL CHECK (length(headings_sha256) = 32),
    mapping TEXT NOT NULL, -- JSON
    changed_at INTEGER NOT NULL,
    PRIMARY KEY (school_id, headings_sha256)
) STRICT;
