-- Pictures of briefings. Those of a revision never change, as it never does; those of a draft go with it.
CREATE TABLE exercise_pictures (
    revision_id BLOB NOT NULL REFERENCES exercise_revisions (id),
    position INTEGER NOT NULL, -- its row in the exercise, from 0
    name TEXT NOT NULL, -- as the exercise names it
    sha256 TEXT NOT NULL,
    width INTEGER NOT NULL, -- pixels
    height INTEGER NOT NULL,
    bytes BLOB NOT NULL,
    PRIMARY KEY (revision_id, position)
) STRICT;

CREATE TRIGGER exercise_pictures_never_change BEFORE UPDATE ON exercise_pictures
BEGIN SELECT RAISE(ABORT, 'a published picture never changes'); END;
CREATE TRIGGER exercise_pictures_never_go BEFORE DELETE ON exercise_pictures
BEGIN SELECT RAISE(ABORT, 'a published picture is never deleted'); END;

CREATE TABLE draft_pictures (
    draft_id BLOB NOT NULL REFERENCES drafts (id) ON DELETE CASCADE,
    name TEXT NOT NULL,
    sha256 TEXT NOT NULL,
    width INTEGER NOT NULL,
    height INTEGER NOT NULL,
    bytes BLOB NOT NULL,
    PRIMARY KEY (draft_id, name)
) STRICT;
