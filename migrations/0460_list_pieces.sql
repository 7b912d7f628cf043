-- Where recordings lie in a bucket, the pieces of an upload are objects of their own; this says which, and in which order. What
-- lies beside them was never counted.
CREATE TABLE upload_pieces (
    upload_id BLOB NOT NULL REFERENCES uploads (id) ON DELETE CASCADE,
    begins INTEGER NOT NULL CHECK (begins >= 0), -- in bytes
    object TEXT NOT NULL, -- its name in the bucket
    PRIMARY KEY (upload_id, begins)
) STRICT, WITHOUT ROWID;
