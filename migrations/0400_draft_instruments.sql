-- Instruments are written in drafts, too: the same table with one more kind.
CREATE TABLE drafts_again (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL REFERENCES schools (id),
    kind TEXT NOT NULL CHECK (kind IN ('exercise', 'course', 'instrument')),
    document_id TEXT NOT NULL, -- of what it will be a revision
    based_on BLOB, -- the revision of an exercise that its meshes come from
    document TEXT NOT NULL, -- TOML
    scene TEXT NOT NULL, -- TOML, of an exercise; empty for any other
    version INTEGER NOT NULL, -- grows with each save: a save names the one it has seen
    saved_by BLOB NOT NULL,
    saved_at INTEGER NOT NULL,
    UNIQUE (school_id, kind, document_id),
    FOREIGN KEY (school_id, based_on) REFERENCES exercise_revisions (school_id, id),
    FOREIGN KEY (school_id, saved_by) REFERENCES people (school_id, id)
) STRICT;

INSERT INTO drafts_again (id, school_id, kind, document_id, based_on, document, scene, version, saved_by, saved_at)
SELECT id, school_id, kind, document_id, based_on, document, scene, version, saved_by, saved_at FROM drafts;
DROP TABLE drafts;
ALTER TABLE drafts_again RENAME TO drafts;
