(* ---- Polynomials on an interval: (d + d x)^n p((a + b x) / (d + d x)) has no negative coefficient ---- *)

Fixpoint spread (a b d : Z) (p : list Z) : list Z * list Z :=
  match p with
  | c :: p' => let (h, w) := spread a b d p' in
      (add (scale c w) (add (scale a h) (0%Z :: scale b h)), add (scale d w) (0%Z :: scale d w))
  | [] => ([], [1%Z])
  end.
Definition nonneg_between (a b d : Z) (p : list Z) : bool :=
  (0 <? d)%Z && (a <? b)%Z && forallb (Z.leb 0) (fst (spread a b d p)) && forallb (Z.leb 0) (fst (spread b b d p)).
Fixpoint nonneg_along (d : Z) (p : list Z) (a : Z) (cuts : list Z) (b : Z) : bool :=
  match cuts with c :: r => nonneg_between a c d p && nonneg_along d p c r b | [] => nonneg_between a b d p end.

Lemma spread_value : forall a b d p x y, IZR a + IZR b * x = IZR d * (1 + x) * y ->
  peval (snd (spread a b d p)) x = (IZR d * (1 + x)) ^ length p /\
  IZR d * (1 + x) * peval (fst (spread a b d p)) x = (IZR d * (1 + x)) ^ length p * peval p y.
Proof.
  intros a b d p x y E; induction p as [|c p [IW IH]]; [simpl; lra|].
  cbn [spread length peval pow]; destruct (spread a b d p) as [h w]; cbn [fst snd] in *.
  rewrite !peval_add, !peval_scale; cbn [peval]; rewrite !peval_scale, IW; split; [ring|].
  set (e := IZR d * (1 + x)) in *; rewrite (Rmult_assoc e), (Rmult_plus_distr_l _ _ (y * _)).
  replace (e * (IZR c * e ^ length p + (IZR a * peval h x + (0 + x * (IZR b * peval h x)))))
    with (e * (e ^ length p * IZR c) + (IZR a + IZR b * x) * (e * peval h x)) by ring.
  rewrite E, IH; ring.
Qed.
Lemma nonneg_between_sound : forall a b d p y, nonneg_between a b d p = true -> IZR a <= IZR d * y <= IZR b -> 0 <= peval p y.
Proof.
  intros a b d p y test Y; unfold nonneg_between in test; rewrite !andb_true_iff, !Z.ltb_lt in test.
  destruct test as [[[D AB] inner] end_]; apply IZR_lt in D, AB.
  assert (all : forall c x, 0 <= x -> IZR c + IZR b * x = IZR d * (1 + x) * y ->
    forallb (Z.leb 0) (fst (spread c b d p)) = true -> 0 <= peval p y).
  { intros c x X E T; destruct (spread_value c b d p x y E) as [_ K]; pose proof (peval_signs _ x T X).
    assert (0 < IZR d * (1 + x)) by nra; assert (0 < (IZR d * (1 + x)) ^ length p) by (now apply pow_lt).
    apply (Rmult_le_reg_l ((IZR d * (1 + x)) ^ length p)); [assumption|]; rewrite <- K; nra. }
  destruct (Req_dec (IZR d * y) (IZR b)) as [e|ne]; [apply (all b 0); [lra|rewrite <- e; ring|exact end_]|].
  apply (all a ((IZR d * y - IZR a) / (IZR b - IZR d * y))); [|field; lra|exact inner].
  apply Rmult_le_pos; [lra|]; left; apply Rinv_0_lt_compat; lra.
Qed.
Lemma nonneg_along_sound : forall d p a cuts b y, nonneg_along d p a cuts b = true -> IZR a <= IZR d * y <= IZR b ->
  0 <= peval p y.
Proof.
  intros d p a cuts; revert a; induction cuts as [|c cuts IH]; intros a b y test Y; cbn [nonneg_along] in test.
  - now apply (nonneg_between_sound a b d).
  - apply andb_true_iff in test as [A B]; destruct (Rle_or_lt (IZR d * y) (IZR c)) as [L|L].
    + apply (nonneg_between_sound a c d); [exact A|lra].
    + apply (IH c b); [exact B|lra].
Qed.

(* The integral of what is a polynomial on an interval. *)
Fixpoint pderiv (p : list Z) : list Z := match p with _ :: p' => add p' (0%Z :: pderiv p') | [] => [] end.
Lemma peval_derivable : forall p y, derivable_pt_lim (peval p) y (peval (pderiv p) y).
Proof.
  induction p as [|c p IH]; intro y; [apply derivable_pt_lim_const|]; cbn [pderiv]; rewrite peval_add; cbn [peval].
  apply (derivable_same (fun y => IZR c + y * peval p y) _ y (0 + (1 * peval p y + y * peval (pderiv p) y)));
    [reflexivity|ring|].
  apply (derivable_pt_lim_plus (fun _ => IZR c) (fun y => y * peval p y)); [apply derivable_pt_lim_const|].
  apply (derivable_pt_lim_mult id (peval p)); [apply derivable_pt_lim_id|apply IH].
Qed.
Lemma primitive_piece : forall (Phi phi : R -> R) q k a b c, integral_of Phi phi ->
  (forall y, a <= y <= b -> k * phi y = peval (pderiv q) y) -> a <= c <= b -> k * Phi c = peval q c ->
  forall y, a <= y <= b -> k * Phi y = peval q y.
Proof.
  intros Phi phi q k a b c [_ D] E C S y Y.
  assert (G : forall x, derivable_pt_lim (fun y => k * Phi y - peval q y) x (k * phi x - peval (pderiv q) x)).
  { intro x; apply (derivable_pt_lim_minus (fun y => k * Phi y) (peval q)); [|apply peval_derivable].
    apply (derivable_pt_lim_scal Phi); apply D. }
  destruct (Rtotal_order c y) as [L|[<-|L]]; [|exact S|].
  - destruct (MVT_cor2 _ _ c y L (fun x _ => G x)) as [x [M X]]; rewrite (E x) in M by lra; lra.
  - destruct (MVT_cor2 _ _ y c L (fun x _ => G x)) as [x [M X]]; rewrite (E x) in M by lra; lra.
Qed.
