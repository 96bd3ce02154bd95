(* ---- Cosines and sines: Taylor's polynomials, angles by doubling, and polynomials times both on intervals ---- *)

(* The part of e^(i x) from (i x)^k/k! on, over i^k, m terms. *)
Fixpoint taylor (m k : nat) (x : R) : C :=
  match m with O => (0, 0) | S n => let r := taylor n (S k) x in (x ^ k / INR (fact k) - snd r, fst r) end.

Lemma fact_pos : forall k, 0 < INR (fact k).
Proof. intro k; apply lt_0_INR, lt_O_fact. Qed.
Lemma power_slope : forall k x, derivable_pt_lim (fun x => x ^ S k / INR (fact (S k))) x (x ^ k / INR (fact k)).
Proof.
  intros k x; pose proof (fact_pos k); pose proof (lt_0_INR (S k) ltac:(lia)).
  apply (derivable_same (fun x => / INR (fact (S k)) * x ^ S k) _ x (/ INR (fact (S k)) * (INR (S k) * x ^ k))).
  - intro s; unfold Rdiv; ring.
  - rewrite fact_simpl, mult_INR; field; split; lra.
  - apply (derivable_pt_lim_scal (fun x => x ^ S k)), (derivable_pt_lim_pow x (S k)).
Qed.
Lemma taylor_slope : forall m k x, derivable_pt_lim (fun x => fst (taylor m (S k) x)) x (fst (taylor m k x)) /\
  derivable_pt_lim (fun x => snd (taylor m (S k) x)) x (snd (taylor m k x)).
Proof.
  induction m as [|m IH]; intros k x; cbn [taylor fst snd]; [split; apply derivable_pt_lim_const|].
  destruct (IH (S k) x) as [A B]; split; [|exact A].
  apply (derivable_pt_lim_minus (fun x => x ^ S k / INR (fact (S k))) (fun x => snd (taylor m (S (S k)) x)));
    [apply power_slope|exact B].
Qed.
Lemma taylor_0 : forall m k, taylor m (S k) 0 = (0, 0).
Proof.
  induction m as [|m IH]; intro k; cbn [taylor]; [reflexivity|]; rewrite IH; cbn [fst snd].
  apply (f_equal2 pair); [|reflexivity]; change (0 ^ S k) with (0 * 0 ^ k); unfold Rdiv; ring.
Qed.
Lemma bounded_by : forall f f' g g', (forall x, derivable_pt_lim f x (f' x)) -> (forall x, derivable_pt_lim g x (g' x)) ->
  f 0 = 0 -> g 0 = 0 -> (forall x, 0 <= x -> Rabs (f' x) <= g' x) -> forall x, 0 <= x -> Rabs (f x) <= g x.
Proof.
  intros f f' g g' F G f0 g0 B x [X| <-]; [|rewrite f0, g0, Rabs_R0; lra].
  assert (P : forall h h', (forall x, derivable_pt_lim h x (h' x)) -> h 0 = 0 -> (forall x, 0 <= x -> 0 <= h' x) -> 0 <= h x).
  { intros h h' D Z N; destruct (MVT_cor2 h h' 0 x X) as [c [E Cc]]; [intros; apply D|]; pose proof (N c ltac:(lra)); nra. }
  assert (S : forall y, 0 <= y -> - g' y <= f' y <= g' y).
  { intros y Y; pose proof (B y Y); pose proof (Rle_abs (f' y)); pose proof (Rle_abs (- f' y)) as N; rewrite Rabs_Ropp in N; lra. }
  apply Rabs_le; split.
  - pose proof (P (g + f)%F (fun x => g' x + f' x)) as K; unfold plus_fct in K.
    enough (0 <= g x + f x) by lra; apply K; [intro; now apply derivable_pt_lim_plus|lra|intros y Y; pose proof (S y Y); lra].
  - pose proof (P (g - f)%F (fun x => g' x - f' x)) as K; unfold minus_fct in K.
    enough (0 <= g x - f x) by lra; apply K; [intro; now apply derivable_pt_lim_minus|lra|intros y Y; pose proof (S y Y); lra].
Qed.
Lemma taylor_bound : forall m x, 0 <= x ->
  Rabs (cos x - fst (taylor m 0 x)) <= x ^ m / INR (fact m) /\ Rabs (sin x - snd (taylor m 0 x)) <= x ^ m / INR (fact m).
Proof.
  induction m as [|m IH]; intros x X.
  - cbn [taylor fst snd pow fact INR]; pose proof (COS_bound x); pose proof (SIN_bound x); split; apply Rabs_le; lra.
  - assert (g0 : 0 ^ S m / INR (fact (S m)) = 0) by (change (0 ^ S m) with (0 * 0 ^ m); unfold Rdiv; ring).
    split; revert x X.
    + apply (bounded_by (fun x => cos x - fst (taylor (S m) 0 x)) (fun x => - sin x - (0 - snd (taylor m 0 x)))
        (fun x => x ^ S m / INR (fact (S m))) (fun x => x ^ m / INR (fact m))).
      * intro x; apply (derivable_pt_lim_minus cos (fun x => fst (taylor (S m) 0 x))); [apply derivable_pt_lim_cos|].
        apply (derivable_pt_lim_minus (fun _ => 1 / 1) (fun x => snd (taylor m 1 x))); [apply derivable_pt_lim_const|apply taylor_slope].
      * apply power_slope.
      * cbn [taylor]; rewrite taylor_0, cos_0; cbn [fst snd pow fact INR]; field.
      * exact g0.
      * intros x X; destruct (IH x X) as [_ B]; rewrite <- Rabs_Ropp.
        replace (- (- sin x - (0 - snd (taylor m 0 x)))) with (sin x - snd (taylor m 0 x)) by ring; exact B.
    + apply (bounded_by (fun x => sin x - snd (taylor (S m) 0 x)) (fun x => cos x - fst (taylor m 0 x))
        (fun x => x ^ S m / INR (fact (S m))) (fun x => x ^ m / INR (fact m))).
      * intro x; apply (derivable_pt_lim_minus sin (fun x => snd (taylor (S m) 0 x))); [apply derivable_pt_lim_sin|].
        apply (proj1 (taylor_slope m 0 x)).
      * apply power_slope.
      * cbn [taylor]; rewrite taylor_0, sin_0; cbn [fst snd]; ring.
      * exact g0.
      * intros x X; apply (IH x X).
Qed.

(* The same in integers: polynomials in t, x = p t / q, times W = q^m m!. *)
Fixpoint nest (m : nat) (j p q : Z) : list Z * list Z * Z :=
  match m with
  | O => ([], [], 1%Z)
  | S n => let '(c, s, W) := nest n (j + 1) p q in ((q * j * W) :: scale (- p) s, 0 :: scale p c, q * j * W)%Z
  end.
Lemma nest_value : forall m k p q t x c s W, 0 < IZR q -> IZR q * x = IZR p * t ->
  nest m (Z.of_nat (S k)) p q = (c, s, W) ->
  x ^ k / INR (fact k) * peval c t = IZR W * fst (taylor m k x) /\
  x ^ k / INR (fact k) * peval s t = IZR W * snd (taylor m k x) /\
  IZR W * INR (fact k) = IZR q ^ m * INR (fact (m + k)).
Proof.
  induction m as [|m IH]; intros k p q t x c s W Q E N.
  - injection N as <- <- <-; cbn [peval taylor fst snd pow plus]; repeat split; ring.
  - cbn [nest] in N; replace (Z.of_nat (S k) + 1)%Z with (Z.of_nat (S (S k))) in N by lia.
    pose proof (eq_sym (INR_IZR_INZ (S k))) as J; set (j := Z.of_nat (S k)) in *; clearbody j.
    destruct (nest m (Z.of_nat (S (S k))) p q) as [[c' s'] W'] eqn:N'.
    destruct (IH (S k) p q t x c' s' W' Q E N') as [Cc [Ss Ww]]; injection N as <- <- <-.
    pose proof (fact_pos k) as f; pose proof (lt_0_INR (S k) ltac:(lia)) as n.
    rewrite Nat.add_succ_r in Ww; cbn [taylor fst snd peval]; rewrite !peval_scale, !mult_IZR, opp_IZR, J.
    rewrite fact_simpl, mult_INR in Cc, Ss, Ww; change (x ^ S k) with (x * x ^ k) in Cc, Ss; change (IZR q ^ S m) with (IZR q * IZR q ^ m).
    repeat split.
    + replace (IZR q * INR (S k) * IZR W' * (x ^ k / INR (fact k) - snd (taylor m (S k) x)))
        with (IZR q * INR (S k) * IZR W' * (x ^ k / INR (fact k)) - IZR q * INR (S k) * (IZR W' * snd (taylor m (S k) x))) by ring.
      rewrite <- Ss; replace (t * (- IZR p * peval s' t)) with (- (IZR q * x) * peval s' t) by (rewrite E; ring); field; lra.
    + replace (IZR q * INR (S k) * IZR W' * fst (taylor m (S k) x)) with (IZR q * INR (S k) * (IZR W' * fst (taylor m (S k) x))) by ring.
      rewrite <- Cc; replace (0 + t * (IZR p * peval c' t)) with (IZR q * x * peval c' t) by (rewrite E; ring); field; lra.
    + replace (IZR q * INR (S k) * IZR W' * INR (fact k)) with (IZR q * (IZR W' * (INR (S k) * INR (fact k)))) by ring.
      rewrite Ww; cbn [plus]; ring.
Qed.
Lemma nest_bound : forall m p q t x c s W, 0 < IZR q -> 0 <= x -> IZR q * x = IZR p * t -> nest m 1 p q = (c, s, W) ->
  0 < IZR W /\ IZR W = IZR q ^ m * INR (fact m) /\
  Rabs (IZR W * cos x - peval c t) <= (IZR p * t) ^ m /\ Rabs (IZR W * sin x - peval s t) <= (IZR p * t) ^ m.
Proof.
  intros m p q t x c s W Q X E N; destruct (nest_value m 0 p q t x c s W Q E N) as [Cc [Ss Ww]].
  rewrite Nat.add_0_r in Ww; cbn [pow fact INR] in Cc, Ss, Ww; pose proof (fact_pos m) as f.
  assert (Qm : 0 < IZR q ^ m) by (now apply pow_lt).
  assert (Wp : 0 < IZR W) by nra.
  assert (R : IZR W * (x ^ m / INR (fact m)) = (IZR p * t) ^ m).
  { rewrite <- E, Rpow_mult_distr; replace (IZR W) with (IZR q ^ m * INR (fact m)) by lra; field; lra. }
  replace (peval c t) with (IZR W * fst (taylor m 0 x)) by lra; replace (peval s t) with (IZR W * snd (taylor m 0 x)) by lra.
  destruct (taylor_bound m x X) as [A B].
  rewrite <- !Rmult_minus_distr_l, !Rabs_mult, (Rabs_right (IZR W)), <- R by lra.
  repeat split; [lra|lra|apply Rmult_le_compat_l; lra|apply Rmult_le_compat_l; lra].
Qed.

(* Cosine and sine of an angle in units of 1 / one, each off by e at most. *)
Definition one : Z := 2 ^ 80.
Definition near (x : R) (v : Z * Z * Z) : Prop := let '(c, s, e) := v in
  0 <= IZR e /\ Rabs (IZR one * cos x - IZR c) <= IZR e /\ Rabs (IZR one * sin x - IZR s) <= IZR e.
Definition twice (v : Z * Z * Z) : Z * Z * Z :=
  let '(c, s, e) := v in (Z.shiftr (c * c - s * s) 80, Z.shiftr (2 * (c * s)) 80, 4 * e + 2)%Z.
Fixpoint doubled (k : nat) (v : Z * Z * Z) : Z * Z * Z := match k with O => v | S n => doubled n (twice v) end.
Definition fine (v : Z * Z * Z) : bool := let '(_, _, e) := v in (2 * e * e <=? one)%Z.

Lemma floor : forall a, Rabs (IZR one * IZR (Z.shiftr a 80) - IZR a) <= IZR one.
Proof.
  intro a; rewrite Z.shiftr_div_pow2 by lia; fold one; assert (P : (0 < one)%Z) by reflexivity.
  pose proof (Z.div_mod a one ltac:(lia)) as D; pose proof (Z.mod_pos_bound a one P) as [L U].
  apply IZR_le in L; apply IZR_lt in U; rewrite D at 2; rewrite plus_IZR, mult_IZR; apply Rabs_le; lra.
Qed.
Lemma products_near : forall x y a b e f M N, Rabs (x - a) <= e -> Rabs (y - b) <= f -> Rabs x <= M -> Rabs y <= N ->
  Rabs (x * y - a * b) <= M * f + (N + f) * e.
Proof.
  intros x y a b e f M N A B Mx Ny; replace (x * y - a * b) with (x * (y - b) + b * (x - a)) by ring.
  apply (Rle_trans _ _ _ (Rabs_triang _ _)); rewrite !Rabs_mult.
  assert (Rabs b <= N + f).
  { replace b with (y + - (y - b)) by ring; apply (Rle_trans _ _ _ (Rabs_triang _ _)); rewrite Rabs_Ropp; lra. }
  apply Rplus_le_compat; apply Rmult_le_compat; try apply Rabs_pos; assumption.
Qed.
Lemma abs_le : forall x e, Rabs x <= e -> - e <= x <= e.
Proof. intros x e H; pose proof (Rle_abs x); pose proof (Rle_abs (- x)) as N; rewrite Rabs_Ropp in N; lra. Qed.
Lemma within_one : forall W x, 0 <= W -> Rabs (W * cos x) <= W /\ Rabs (W * sin x) <= W.
Proof. intros W x P; pose proof (COS_bound x); pose proof (SIN_bound x); split; apply Rabs_le; nra. Qed.
Lemma one_pos : 0 < IZR one.
Proof. apply IZR_lt; reflexivity. Qed.
Lemma twice_near : forall x v, fine v = true -> near x v -> near (2 * x) (twice v).
Proof.
  intros x [[c s] e] F [P [Hc Hs]]; apply Z.leb_le, IZR_le in F; rewrite !mult_IZR in F; cbn [twice near].
  pose proof one_pos as B; destruct (within_one (IZR one) x ltac:(lra)) as [Mc Ms].
  set (K := IZR one) in *; set (X := K * cos x) in *; set (Y := K * sin x) in *.
  pose proof (products_near X X _ _ _ _ K K Hc Hc Mc Mc) as Q1; pose proof (products_near Y Y _ _ _ _ K K Hs Hs Ms Ms) as Q2.
  pose proof (products_near X Y _ _ _ _ K K Hc Hs Mc Ms) as Q3.
  pose proof (floor (c * c - s * s)) as F1; pose proof (floor (2 * (c * s))) as F2; fold K in F1, F2.
  rewrite minus_IZR, !mult_IZR in F1; rewrite !mult_IZR in F2; rewrite !plus_IZR, mult_IZR.
  assert (E1 : K * (K * cos (2 * x)) = X * X - Y * Y) by (unfold X, Y; rewrite cos_2a; ring).
  assert (E2 : K * (K * sin (2 * x)) = 2 * (X * Y)) by (unfold X, Y; rewrite sin_2a; ring).
  apply abs_le in Q1, Q2, Q3, F1, F2.
  split; [lra|]; split; apply Rabs_le; split; apply (Rmult_le_reg_l K); try exact B; lra.
Qed.
Lemma doubled_near : forall k x v, fine (doubled k v) = true -> near x v -> near (2 ^ k * x) (doubled k v).
Proof.
  assert (back : forall k v, 0 <= IZR (snd v) -> fine (doubled k v) = true -> fine v = true).
  { induction k as [|k IH]; intros [[c s] e] P F; [exact F|]; cbn [snd] in P; apply le_IZR in P.
    apply IH in F; [|cbn [twice snd]; apply IZR_le; lia].
    cbn [twice fine] in *; apply Z.leb_le in F; apply Z.leb_le; nia. }
  induction k as [|k IH]; intros x v F N; [rewrite Rmult_1_l; exact N|].
  change (2 ^ S k) with (2 * 2 ^ k); replace (2 * 2 ^ k * x) with (2 ^ k * (2 * x)) by ring.
  apply IH; [exact F|]; apply twice_near; [|exact N]; apply (back (S k)); [|exact F].
  destruct v as [[c s] e]; apply N.
Qed.

(* The angle p / q: Taylor's polynomial at p / (2^k q), k times doubled. *)
Fixpoint nest_1 (m : nat) (j p q : Z) : Z * Z * Z :=
  match m with
  | O => (0, 0, 1)%Z
  | S n => let '(c, s, W) := nest_1 n (j + 1) p q in let qjW := (q * j * W)%Z in (qjW - p * s, p * c, qjW)%Z
  end.
Definition angle_by (m k : nat) (p q : Z) : Z * Z * Z :=
  let '(c, s, W) := nest_1 m 1 p (q * 2 ^ Z.of_nat k) in doubled k (one * c / W, one * s / W, 2)%Z.
Definition small_by (m k : nat) (p q : Z) : bool :=
  (0 <=? p)%Z && (one * p ^ Z.of_nat m <=? snd (nest_1 m 1 p (q * 2 ^ Z.of_nat k)))%Z && fine (angle_by m k p q).
Definition angle : Z -> Z -> Z * Z * Z := angle_by 9 16.
Definition small : Z -> Z -> bool := small_by 9 16.

Lemma nest_at_1 : forall m j p q, let '(c, s, W) := nest m j p q in let '(c1, s1, W1) := nest_1 m j p q in
  peval c 1 = IZR c1 /\ peval s 1 = IZR s1 /\ W = W1.
Proof.
  induction m as [|m IH]; intros j p q; cbn [nest nest_1 peval]; [repeat split|].
  specialize (IH (j + 1)%Z p q); destruct (nest m (j + 1) p q) as [[c s] W]; destruct (nest_1 m (j + 1) p q) as [[c1 s1] W1].
  destruct IH as [Hc [Hs ->]]; cbn [peval]; rewrite !peval_scale, Hc, Hs, minus_IZR, !mult_IZR, opp_IZR; repeat split; ring.
Qed.
Lemma quotient : forall a W x, 0 < IZR W -> Rabs (IZR W * x - IZR a) <= IZR W -> Rabs (x - IZR (a / W)) <= 2.
Proof.
  intros a W x P H; apply lt_IZR in P; pose proof (Z.div_mod a W ltac:(lia)) as D.
  pose proof (Z.mod_pos_bound a W P) as [L U]; apply IZR_lt in P, U; apply IZR_le in L.
  apply (f_equal IZR) in D; rewrite plus_IZR, mult_IZR in D; apply abs_le in H.
  apply Rabs_le; split; apply (Rmult_le_reg_l (IZR W)); try exact P; lra.
Qed.
Lemma angle_near : forall m k p q, 0 < IZR q -> small_by m k p q = true -> near (IZR p / IZR q) (angle_by m k p q).
Proof.
  intros m k p q Q T; unfold small_by in T; rewrite !andb_true_iff, !Z.leb_le in T; destruct T as [[P B] F].
  apply IZR_le in P, B; unfold angle_by in *.
  pose proof (nest_at_1 m 1 p (q * 2 ^ Z.of_nat k)) as A; destruct (nest_1 m 1 p (q * 2 ^ Z.of_nat k)) as [[c s] W].
  destruct (nest m 1 p (q * 2 ^ Z.of_nat k)) as [[c1 s1] W1] eqn:N; destruct A as [Ac [As ->]]; cbn [snd] in B.
  assert (K : 0 < 2 ^ k) by (apply pow_lt; lra).
  assert (Q' : IZR (q * 2 ^ Z.of_nat k) = IZR q * 2 ^ k) by (rewrite mult_IZR, <- pow_IZR; reflexivity).
  assert (Q1 : 0 < IZR (q * 2 ^ Z.of_nat k)) by (rewrite Q'; nra).
  set (x := IZR p / IZR (q * 2 ^ Z.of_nat k)).
  assert (X : 0 <= x) by (apply Rmult_le_pos; [exact P|left; now apply Rinv_0_lt_compat]).
  assert (E : IZR (q * 2 ^ Z.of_nat k) * x = IZR p * 1) by (unfold x; field; lra).
  destruct (nest_bound m p _ 1 x c1 s1 W Q1 X E N) as [Wp [_ [Hc Hs]]].
  rewrite Ac, Rmult_1_r, pow_IZR in Hc; rewrite As, Rmult_1_r, pow_IZR in Hs; rewrite mult_IZR in B; set (r := IZR (p ^ Z.of_nat m)) in *.
  replace (IZR p / IZR q) with (2 ^ k * x) by (unfold x; rewrite Q'; field; split; lra).
  apply (doubled_near k x _ F); pose proof one_pos as O.
  assert (scaled : forall f a, Rabs (IZR W * f - IZR a) <= r -> Rabs (IZR one * f - IZR (one * a / W)) <= 2).
  { intros f a H; apply quotient; [exact Wp|]; apply abs_le in H; rewrite mult_IZR; apply Rabs_le; nra. }
  cbn [near]; split; [lra|]; split; apply scaled; assumption.
Qed.

(* P(u) cos (p u / q) + Q(u) sin (p u / q), terms (p, (P, Q)). *)
Definition wave : Type := (Z * (list Z * list Z))%type.
Fixpoint waves (q : Z) (ts : list wave) (u : R) : R :=
  match ts with
  | (p, (P, Q)) :: r =>
      peval P u * cos (IZR p / IZR q * u) + peval Q u * sin (IZR p / IZR q * u) + waves q r u
  | [] => 0
  end.
(* p(a + t) *)
Fixpoint moved (a : Z) (p : list Z) : list Z := match p with c :: r => let s := moved a r in add (c :: s) (scale a s) | [] => [] end.
Definition sizes (p q : list Z) : list Z := add (map Z.abs p) (map Z.abs q).
(* A polynomial of t below one W times the waves at a + t, 0 <= t <= h. *)
Fixpoint below (m : nat) (q a h : Z) (ts : list wave) : list Z :=
  match ts with
  | (p, (P, Q)) :: r =>
      let '(c, s, e) := angle (p * a) q in let '(c', s', W) := nest m 1 p q in
      let P' := moved a P in let Q' := moved a Q in
      add (add (pmul c' (add (scale c P') (scale s Q'))) (pmul s' (add (scale c Q') (scale (- s) P'))))
        (add (scale (- 2 * (W * e + (one + e) * (p * h) ^ Z.of_nat m)) (sizes P' Q')) (below m q a h r))
  | [] => []
  end.
Definition on_interval (m : nat) (q a h : Z) (p : list Z) (ts : list wave) : bool :=
  (0 <? h)%Z && forallb (fun t => (0 <=? fst t)%Z && small (fst t * a) q) ts &&
  nonneg_between 0 h 1 (add (scale (one * snd (nest m 1 0 q)) (moved a p)) (below m q a h ts)).
(* From a on: polynomials T >= 0 of u - a with T^2 >= P^2 + Q^2 for each wave. *)
Fixpoint topped (a : Z) (ts : list wave) (tops : list (list Z)) : bool :=
  match ts, tops with
  | (_, (P, Q)) :: r, T :: s =>
      let P' := moved a P in let Q' := moved a Q in
      forallb (Z.leb 0) T && forallb (Z.leb 0) (add (pmul T T) (scale (-1) (add (pmul P' P') (pmul Q' Q')))) && topped a r s
  | [], [] => true
  | _, _ => false
  end.
Fixpoint everywhere (m : nat) (q a : Z) (hs : list Z) (p : list Z) (ts : list wave) (tops : list (list Z)) : bool :=
  match hs with
  | h :: r => on_interval m q a h p ts && everywhere m q (a + h) r p ts tops
  | [] => topped a ts tops && forallb (Z.leb 0) (add (moved a p) (scale (-1) (fold_right add [] tops)))
  end.

Lemma peval_moved : forall a p t, peval (moved a p) t = peval p (IZR a + t).
Proof.
  intros a p t; induction p as [|c p IH]; [reflexivity|].
  cbn [moved]; rewrite peval_add, peval_scale; cbn [peval]; rewrite IH; ring.
Qed.
Lemma peval_abs : forall p t, 0 <= t -> Rabs (peval p t) <= peval (map Z.abs p) t.
Proof.
  induction p as [|c p IH]; intros t T; cbn [map peval]; [rewrite Rabs_R0; lra|].
  apply (Rle_trans _ _ _ (Rabs_triang _ _)); rewrite Rabs_mult, (Rabs_right t), abs_IZR by lra.
  apply Rplus_le_compat_l, Rmult_le_compat_l; [exact T|]; now apply IH.
Qed.
Lemma sizes_above : forall P Q t, 0 <= t -> Rabs (peval P t) + Rabs (peval Q t) <= peval (sizes P Q) t.
Proof. intros P Q t T; unfold sizes; rewrite peval_add; pose proof (peval_abs P t T); pose proof (peval_abs Q t T); lra. Qed.
Lemma wave_above : forall P Q T x, 0 <= T -> 0 <= T * T - (P * P + Q * Q) -> - T <= P * cos x + Q * sin x.
Proof.
  intros P Q T x T0 H; pose proof (sin2_cos2 x) as E; unfold Rsqr in E; apply Rnot_lt_le; intro L.
  assert (T * T < (P * cos x + Q * sin x) * (P * cos x + Q * sin x)) by nra.
  assert ((P * cos x + Q * sin x) * (P * cos x + Q * sin x) + (P * sin x - Q * cos x) * (P * sin x - Q * cos x) = P * P + Q * Q).
  { replace (P * P + Q * Q) with ((P * P + Q * Q) * (sin x * sin x + cos x * cos x)) by (rewrite E; ring); ring. }
  pose proof (Rle_0_sqr (P * sin x - Q * cos x)) as S; unfold Rsqr in S; lra.
Qed.

(* One wave: K cos, K sin at a within e, W cos, W sin beside it within r. *)
Lemma one_wave : forall P Q x y K W c s C S e r, 0 <= K -> 0 <= W ->
  Rabs (K * cos x - c) <= e -> Rabs (K * sin x - s) <= e -> Rabs (W * cos y - C) <= r -> Rabs (W * sin y - S) <= r ->
  C * (c * P + s * Q) + S * (c * Q - s * P) - 2 * (W * e + (K + e) * r) * (Rabs P + Rabs Q)
    <= K * W * (P * cos (x + y) + Q * sin (x + y)).
Proof.
  intros P Q x y K W c s C S e r Kp Wp Hc Hs HC HS.
  destruct (within_one W y Wp) as [MC MS]; destruct (within_one K x Kp) as [Mc Ms].
  pose proof (abs_le _ _ (products_near _ _ _ _ _ _ _ _ HC Hc MC Mc)) as CC.
  pose proof (abs_le _ _ (products_near _ _ _ _ _ _ _ _ HC Hs MC Ms)) as CS.
  pose proof (abs_le _ _ (products_near _ _ _ _ _ _ _ _ HS Hc MS Mc)) as SC.
  pose proof (abs_le _ _ (products_near _ _ _ _ _ _ _ _ HS Hs MS Ms)) as SS.
  set (d := W * e + (K + e) * r) in *.
  replace (K * W * (P * cos (x + y) + Q * sin (x + y)))
    with (P * (W * cos y * (K * cos x) - W * sin y * (K * sin x)) + Q * (W * cos y * (K * sin x) + W * sin y * (K * cos x)))
    by (rewrite cos_plus, sin_plus; ring).
  assert (B : forall a u v, - (2 * d) <= u - v <= 2 * d -> a * v - 2 * d * Rabs a <= a * u).
  { intros a u v H; pose proof (Rle_abs a); pose proof (Rle_abs (- a)) as N; rewrite Rabs_Ropp in N; nra. }
  pose proof (B P (W * cos y * (K * cos x) - W * sin y * (K * sin x)) (C * c - S * s) ltac:(lra)).
  pose proof (B Q (W * cos y * (K * sin x) + W * sin y * (K * cos x)) (C * s + S * c) ltac:(lra)).
  lra.
Qed.
Lemma below_sound : forall m q a h W ts t, 0 < IZR q -> 0 <= t <= IZR h -> W = IZR q ^ m * INR (fact m) ->
  forallb (fun t => (0 <=? fst t)%Z && small (fst t * a) q) ts = true ->
  peval (below m q a h ts) t <= IZR one * W * waves q ts (IZR a + t).
Proof.
  intros m q a h W ts t Q T E; induction ts as [|[p [P Q0]] ts IH]; intro F; [cbn [below waves peval]; lra|].
  cbn [forallb fst] in F; rewrite !andb_true_iff, Z.leb_le in F; destruct F as [[p0 F] F']; specialize (IH F'); apply IZR_le in p0.
  unfold small in F; pose proof (angle_near 9 16 (p * a)%Z q Q F) as N; clear F; cbn [below waves]; unfold angle at 1.
  set (v := angle_by 9 16 (p * a) q) in *; clearbody v.
  destruct v as [[c s] e]; destruct (nest m 1 p q) as [[c' s'] W'] eqn:M; destruct N as [e0 [Hc Hs]].
  set (y := IZR p / IZR q * t); assert (i0 : 0 < / IZR q) by (now apply Rinv_0_lt_compat).
  destruct (nest_bound m p q t y c' s' W' Q ltac:(unfold y, Rdiv; apply Rmult_le_pos; [apply Rmult_le_pos; lra|lra])
    ltac:(unfold y; field; lra) M) as [Wp [E' [HC HS]]].
  assert (R : (IZR p * t) ^ m <= IZR ((p * h) ^ Z.of_nat m)) by (rewrite <- pow_IZR, mult_IZR; apply pow_incr; split; nra).
  pose proof one_pos as O; assert (EW : W = IZR W') by lra; subst W; rewrite EW in *.
  pose proof (one_wave (peval P (IZR a + t)) (peval Q0 (IZR a + t)) _ y (IZR one) (IZR W') _ _ _ _ _ _ ltac:(lra) ltac:(lra) Hc Hs
    (Rle_trans _ _ _ HC R) (Rle_trans _ _ _ HS R)) as K.
  replace (IZR (p * a) / IZR q + y) with (IZR p / IZR q * (IZR a + t)) in K by (unfold y; rewrite mult_IZR; field; lra).
  pose proof (sizes_above (moved a P) (moved a Q0) t (proj1 T)) as Z.
  repeat (rewrite peval_add || rewrite peval_mul || rewrite peval_scale); rewrite !peval_moved in *.
  repeat (rewrite mult_IZR || rewrite plus_IZR || rewrite opp_IZR).
  set (r := IZR ((p * h) ^ Z.of_nat m)) in *; set (d := IZR W' * IZR e + (IZR one + IZR e) * r) in *.
  assert (d0 : 0 <= d) by (assert (0 <= r) by (apply Rle_trans with ((IZR p * t) ^ m); [apply pow_le; nra|exact R]); unfold d; nra).
  apply (Rmult_le_compat_l (2 * d)) in Z; [|lra]; lra.
Qed.
Theorem everywhere_sound : forall m q p ts tops hs a, 0 < IZR q -> everywhere m q a hs p ts tops = true ->
  forall u, IZR a <= u -> 0 <= peval p u + waves q ts u.
Proof.
  intros m q p ts tops hs; induction hs as [|h hs IH]; intros a Q F u U; cbn [everywhere] in F.
  - apply andb_true_iff in F as [G F]; assert (D : IZR a + (u - IZR a) = u) by ring.
    pose proof (peval_signs _ (u - IZR a) F ltac:(lra)) as H; rewrite peval_add, peval_scale, peval_moved, D in H.
    enough (K : - peval (fold_right add [] tops) (u - IZR a) <= waves q ts u) by lra; clear H F.
    revert ts G; induction tops as [|T tops IH]; intros [|[k [P Q0]] ts] G; cbn [topped] in G; try discriminate;
      cbn [fold_right waves]; [cbn [peval]; lra|].
    rewrite !andb_true_iff in G; destruct G as [[T0 G] rest]; specialize (IH ts rest); rewrite peval_add.
    apply (peval_signs _ (u - IZR a)) in T0; [|lra]; apply (peval_signs _ (u - IZR a)) in G; [|lra].
    rewrite peval_add, peval_scale, peval_add, !peval_mul, !peval_moved, D in G.
    pose proof (wave_above (peval P u) (peval Q0 u) _ (IZR k / IZR q * u) T0 ltac:(lra)); lra.
  - apply andb_true_iff in F as [F rest]; destruct (Rle_or_lt (IZR a + IZR h) u) as [B|B];
      [apply (IH (a + h)%Z Q rest); rewrite plus_IZR; exact B|].
    unfold on_interval in F; rewrite !andb_true_iff in F; destruct F as [[_ F] N].
    pose proof (nonneg_between_sound _ _ _ _ (u - IZR a) N ltac:(lra)) as K; rewrite peval_add, peval_scale, peval_moved in K.
    replace (IZR a + (u - IZR a)) with u in K by ring.
    destruct (nest m 1 0 q) as [[c s] W] eqn:M; cbn [snd] in K.
    destruct (nest_bound m 0 q 0 0 c s W Q ltac:(lra) ltac:(ring) M) as [Wp [E _]].
    pose proof (below_sound m q a h (IZR W) ts (u - IZR a) Q ltac:(lra) E F) as L.
    replace (IZR a + (u - IZR a)) with u in L by ring; rewrite mult_IZR in K; pose proof one_pos as O.
    apply (Rmult_le_reg_l (IZR one * IZR W)); [nra|]; lra.
Qed.
