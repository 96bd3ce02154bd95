from lure.analysis.export.coq import coq_text as coq_text
