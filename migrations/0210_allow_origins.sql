-- Origins whose pages may upload to a school with a token, from a browser.
CREATE TABLE school_origins (
    school_id BLOB NOT NULL REFERENCES schools (id),
    origin TEXT NOT NULL CHECK (origin GLOB 'http://?*' OR origin GLOB 'https://?*'),
    PRIMARY KEY (school_id, origin)
) STRICT, WITHOUT ROWID;
CREATE INDEX school_origins_by_origin ON school_origins (origin);
